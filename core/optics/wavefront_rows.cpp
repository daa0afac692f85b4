#include "core/optics/wavefront_rows.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/optics/zernike_terms.hpp"

namespace ovws {
namespace {

double binomial(int n, int k) {
  double value = 1.0;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

/// Sign of the term x^(m-b) y^b in the real or imaginary part of (x + i y)^m: Re or Im of i^b.
double power_sign(int b, bool imaginary) {
  if ((b % 2 != 0) != imaginary) return 0.0;
  return b % 4 < 2 ? 1.0 : -1.0;
}

double horner(const std::vector<double>& by_rising_power, double at) {
  double value = 0.0;
  for (std::size_t k = by_rising_power.size(); k-- > 0;) value = value * at + by_rising_power[k];
  return value;
}

std::vector<double> derivative(const std::vector<double>& by_rising_power) {
  std::vector<double> derived(std::max<std::size_t>(by_rising_power.size() - 1, 1), 0.0);
  for (std::size_t k = 1; k < by_rising_power.size(); ++k) {
    derived[k - 1] = static_cast<double>(k) * by_rising_power[k];
  }
  return derived;
}

/// Adds one mode's x^a y^b terms to terms[a][b].
void add_mode(const ZernikeTerms& mode, double waves, std::vector<std::vector<double>>& terms) {
  const int m = std::abs(mode.m);
  for (int k = 0; k < mode.count; ++k) {
    for (int c = 0; c <= k; ++c) {  // s^k = sum over c of binomial(k, c) x^(2k-2c) y^(2c)
      for (int b = 0; b <= m; ++b) {
        const double sign = power_sign(b, mode.m < 0) * binomial(m, b);
        const int x_power = 2 * (k - c) + m - b;
        const int y_power = 2 * c + b;
        terms[x_power][y_power] += waves * mode.radial[k] * binomial(k, c) * sign;
      }
    }
  }
}

/// Coefficients of (p x + q y)^n by rising power of x (binomial theorem).
std::vector<double> power_of_sum(double p, double q, int n) {
  std::vector<double> powers;
  for (int k = 0; k <= n; ++k)
    powers.push_back(binomial(n, k) * std::pow(p, k) * std::pow(q, n - k));
  return powers;
}

/// Rotates a polynomial: converts `terms` from the SLM's axes to those of a camera with `turn`.
std::vector<std::vector<double>> turned(const std::vector<std::vector<double>>& terms,
                                        const PxPerCycle& turn) {
  const Vec2 by_x = turn.back({1.0, 0.0}), by_y = turn.back({0.0, 1.0});
  std::vector<std::vector<double>> out;
  for (const auto& in_y : terms) out.emplace_back(in_y.size(), 0.0);
  for (std::size_t a = 0; a < terms.size(); ++a) {
    const auto x = power_of_sum(by_x.x, by_y.x, int(a));
    for (std::size_t b = 0; b < terms[a].size(); ++b) {
      const auto y = power_of_sum(by_x.y, by_y.y, int(b));
      for (std::size_t i = 0; i <= a; ++i) {
        for (std::size_t j = 0; j <= b; ++j) {
          out[i + j][a + b - i - j] += terms[a][b] * x[i] * y[j];
        }
      }
    }
  }
  return out;
}

}  // namespace

WavefrontRows::WavefrontRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px,
                             const PxPerCycle& turn)
    : centre_px_(centre_px), radius_px_(0.5 * diameter_px) {
  int degree = 0;
  for (const Mode& mode : modes) degree = std::max(degree, zernike_terms(mode.j).n);
  for (int a = 0; a <= degree; ++a) terms_.emplace_back(degree + 1 - a, 0.0);
  for (const Mode& mode : modes) add_mode(zernike_terms(mode.j), mode.waves, terms_);
  if (turn != PxPerCycle(turn.scale())) terms_ = turned(terms_, turn);
}

void WavefrontRows::along_row(int y, Polynomial& p) const {
  p.clear();
  for (const Polynomial& in_y : terms_) p.push_back(horner(in_y, (y - centre_px_.y) / radius_px_));
}

void WavefrontRows::evaluate(const Polynomial& p, int first_x, std::span<double> out) const {
  const auto n = static_cast<Eigen::Index>(out.size());
  const double x0 = (first_x - centre_px_.x) / radius_px_;
  const double x1 = (first_x + static_cast<double>(n - 1) - centre_px_.x) / radius_px_;
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(n, x0, x1);
  Eigen::Map<Eigen::ArrayXd> sum(out.data(), n);
  sum.setConstant(p.back());
  for (std::size_t k = p.size() - 1; k-- > 0;) sum = sum * x + p[k];
}

void WavefrontRows::waves(int y, int first_x, std::span<double> out) const {
  Polynomial p;
  along_row(y, p);
  evaluate(p, first_x, out);
}

void WavefrontRows::slopes_x(int y, int first_x, std::span<double> out) const {
  Polynomial p;
  along_row(y, p);
  p = derivative(p);
  for (double& term : p) term /= radius_px_;
  evaluate(p, first_x, out);
}

void WavefrontRows::slopes_y(int y, int first_x, std::span<double> out) const {
  Polynomial p;
  const double in_pupil = (y - centre_px_.y) / radius_px_;
  for (const Polynomial& in_y : terms_) {
    p.push_back(horner(derivative(in_y), in_pupil) / radius_px_);
  }
  evaluate(p, first_x, out);
}

}  // namespace ovws
