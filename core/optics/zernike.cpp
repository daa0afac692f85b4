#include "core/optics/zernike.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include "core/optics/zernike_terms.hpp"

namespace ovws {
namespace {

/// Radial polynomial R(rho) = rho^|m| q(rho^2): values of q(s) and q'(s) by Horner's scheme.
struct Radial {
  double value;
  double slope;
};
Radial radial(const ZernikeTerms& terms, double s) {
  double value = 0.0;
  double slope = 0.0;
  for (int k = terms.count - 1; k >= 0; --k) {
    slope = slope * s + value;
    value = value * s + terms.radial[k];
  }
  return {value, slope};
}

/// Complex power (x + i y)^power as (real, imaginary); z = (x, y).
Vec2 complex_power(Vec2 z, int power) {
  Vec2 w{1.0, 0.0};
  for (int k = 0; k < power; ++k) w = {w.x * z.x - w.y * z.y, w.x * z.y + w.y * z.x};
  return w;
}

}  // namespace

int osa_index(ZernikeIndex index) {
  return (index.n * (index.n + 2) + index.m) / 2;
}

std::optional<int> checked_osa_index(int n, int m) {
  // Check the range of n and m first, so that osa_index cannot overflow.
  constexpr int kMaxOrder = 20;
  if (n < 0 || n > kMaxOrder || m < -n || m > n || (n - std::abs(m)) % 2 != 0) return std::nullopt;
  return osa_index({n, m});
}

ZernikeIndex zernike_index(int j) {
  assert(j >= 0);
  int n = 0;
  while ((n + 1) * (n + 2) / 2 <= j) ++n;
  return {n, 2 * j - n * (n + 2)};
}

std::string zernike_name(int j) {
  static constexpr std::array kNames{"piston",
                                     "vertical tilt",
                                     "horizontal tilt",
                                     "oblique astigmatism",
                                     "defocus",
                                     "vertical astigmatism",
                                     "vertical trefoil",
                                     "vertical coma",
                                     "horizontal coma",
                                     "oblique trefoil",
                                     "oblique quadrafoil",
                                     "oblique secondary astigmatism",
                                     "primary spherical",
                                     "vertical secondary astigmatism",
                                     "vertical quadrafoil"};
  if (j >= 0 && j < static_cast<int>(kNames.size())) return kNames[j];
  const ZernikeIndex index = zernike_index(j);
  return "Z(" + std::to_string(index.n) + "," + std::to_string(index.m) + ")";
}

double zernike_rms_factor(int j) {
  const ZernikeIndex index = zernike_index(j);
  return std::sqrt((index.m == 0 ? 1.0 : 2.0) * (index.n + 1));
}

void add_mode(std::vector<Mode>& modes, const Mode& mode) {
  const auto same = std::ranges::find(modes, mode.j, &Mode::j);
  if (same == modes.end()) return modes.push_back(mode);
  same->waves += mode.waves;
}

double zernike(int j, Vec2 at) {
  const ZernikeTerms& terms = zernike_terms(j);
  const Vec2 power = complex_power(at, std::abs(terms.m));
  return radial(terms, at.x * at.x + at.y * at.y).value * (terms.m < 0 ? power.y : power.x);
}

void zernike_values(Vec2 at, std::span<double> values) {
  std::array<Vec2, kMaxZernikeIndex + 1> powers;  // of x + i y
  const int orders = values.empty() ? 0 : zernike_index(int(values.size()) - 1).n + 1;
  powers[0] = {1.0, 0.0};
  for (int k = 1; k < orders; ++k) {
    const Vec2 w = powers[std::size_t(k) - 1];
    powers[std::size_t(k)] = {w.x * at.x - w.y * at.y, w.x * at.y + w.y * at.x};
  }
  const double square = at.x * at.x + at.y * at.y;
  for (std::size_t j = 0; j < values.size(); ++j) {
    const ZernikeTerms& terms = zernike_terms(int(j));
    const Vec2 power = powers[std::size_t(std::abs(terms.m))];
    values[j] = radial(terms, square).value * (terms.m < 0 ? power.y : power.x);
  }
}

Vec2 zernike_gradient(int j, Vec2 at) {
  const ZernikeTerms& terms = zernike_terms(j);
  const int m = std::abs(terms.m);
  const Radial q = radial(terms, at.x * at.x + at.y * at.y);
  const double angular = terms.m < 0 ? complex_power(at, m).y : complex_power(at, m).x;
  Vec2 gradient = 2.0 * q.slope * angular * at;
  if (m > 0) {
    const Vec2 w = static_cast<double>(m) * complex_power(at, m - 1);
    gradient = gradient + q.value * (terms.m < 0 ? Vec2{w.y, w.x} : Vec2{w.x, -w.y});
  }
  return gradient;
}

double wavefront(std::span<const Mode> modes, Vec2 at) {
  double sum = 0.0;
  for (const Mode& mode : modes) sum += mode.waves * zernike(mode.j, at);
  return sum;
}

Vec2 wavefront_gradient(std::span<const Mode> modes, Vec2 at) {
  Vec2 sum;
  for (const Mode& mode : modes) sum = sum + mode.waves * zernike_gradient(mode.j, at);
  return sum;
}

int optimal_mode_count(int subapertures_across) {
  return static_cast<int>(2.04 * std::pow(subapertures_across, 1.36));
}

}  // namespace ovws
