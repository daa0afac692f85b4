#include "drivers/twin/turbulence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/optics/zernike.hpp"

namespace ovws::twin {
namespace {

constexpr int kWaves = 300;
constexpr int kRemoved = 3;  ///< modes that `tilt: false` takes out: j = 0, 1, 2
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Bessel ratio 2 J_(n+1)(kappa) / kappa. `kappa`: spatial frequency, radians per pupil radius.
double bessel_ratio(int n, double kappa) {
  return 2.0 * std::cyl_bessel_j(double(n + 1), kappa) / kappa;
}

/// Fraction of a plane wave's power over the pupil that remains without piston and tilts.
double power_beyond_tilt(double kappa) {
  const double piston = bessel_ratio(0, kappa), tilt = bessel_ratio(1, kappa);
  return std::max(0.0, 1.0 - piston * piston - 4.0 * tilt * tilt);
}

double kappa_of(Vec2 cycles_per_radius) {
  return kTwoPi * norm(cycles_per_radius);
}

std::complex<double> power_of_i(int m) {
  constexpr std::array<std::complex<double>, 4> kPowers{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  return kPowers[std::size_t(m % 4)];
}

}  // namespace

Turbulence::Turbulence(const TurbulenceConfig& config) : config_(config), waves_(kWaves) {
  const double towards = config.direction_deg * std::numbers::pi / 180.0;
  radii_per_s_ = 2.0 * config.speed_pupils_per_s * Vec2{std::cos(towards), std::sin(towards)};
  std::mt19937_64 random{std::uint64_t(config.seed)};
  const auto uniform = [&random] { return double(random() >> 11) * 0x1.0p-53; };
  const double lowest = std::log(0.25 / std::max(config.outer_scale_pupils, 1.0));
  const double highest = std::log(kMaxCycles);
  for (int k = 0; k < kWaves; ++k) {
    Wave& wave = waves_[std::size_t(k)];
    const double cycles = std::exp(lowest + (highest - lowest) * (k + uniform()) / kWaves);
    const double direction = kTwoPi * uniform();
    wave.cycles_per_radius = (0.5 * cycles) * Vec2{std::cos(direction), std::sin(direction)};
    wave.start_cycles = uniform();
    const double knee = 1.0 / config.outer_scale_pupils;
    // The power in a spectral ring of width d ln f is f^2 times the spectral density; the amplitude
    // is its square root.
    wave.waves = cycles * std::pow(cycles * cycles + knee * knee, -11.0 / 12.0);
  }
  scale_to_rms();
  for (Wave& wave : waves_) fill_modes(wave);
}

void Turbulence::scale_to_rms() {
  double power = 0.0;
  for (const Wave& wave : waves_) {
    power += 0.5 * wave.waves * wave.waves * power_beyond_tilt(kappa_of(wave.cycles_per_radius));
  }
  for (Wave& wave : waves_) wave.waves *= config_.rms_waves / std::sqrt(power);
}

void Turbulence::fill_modes(Wave& wave) const {
  const double kappa = kappa_of(wave.cycles_per_radius);
  const double direction = std::atan2(wave.cycles_per_radius.y, wave.cycles_per_radius.x);
  for (int j = 0; j < kModes; ++j) {
    const ZernikeIndex index = zernike_index(j);
    const int m = std::abs(index.m);
    const double angular = index.m < 0 ? std::sin(m * direction) : std::cos(m * direction);
    const double sign = (index.n - m) / 2 % 2 == 0 ? 1.0 : -1.0;
    wave.modes[std::size_t(j)] = wave.waves * zernike_rms_factor(j) * sign * angular *
                                 bessel_ratio(index.n, kappa) * power_of_i(m);
  }
}

double Turbulence::phase_at_centre(const Wave& wave, std::int64_t t_ns) const {
  // long double: a double cannot resolve a fraction of a cycle over decades of nanoseconds.
  const long double cycles_per_s =
      (long double)(wave.cycles_per_radius.x) * (long double)(radii_per_s_.x) +
      (long double)(wave.cycles_per_radius.y) * (long double)(radii_per_s_.y);
  const long double cycles = cycles_per_s * (long double)(t_ns)*1e-9L;
  return kTwoPi * (wave.start_cycles - double(cycles - std::floor(cycles)));
}

Turbulence::Modes Turbulence::all_modes(std::int64_t t_ns) const {
  Modes modes{};
  for (const Wave& wave : waves_) {
    const double phase = phase_at_centre(wave, t_ns);
    const double re = std::cos(phase), im = std::sin(phase);
    for (std::size_t j = 0; j < modes.size(); ++j) {
      modes[j] += wave.modes[j].real() * re - wave.modes[j].imag() * im;
    }
  }
  return modes;
}

Turbulence::Modes Turbulence::modes(std::int64_t t_ns) const {
  Modes modes = all_modes(t_ns);
  if (!config_.tilt) std::fill(modes.begin(), modes.begin() + kRemoved, 0.0);
  return modes;
}

double Turbulence::waves(Vec2 at, std::int64_t t_ns) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) {
    const Vec2 f = wave.cycles_per_radius;
    sum += wave.waves * std::cos(phase_at_centre(wave, t_ns) + kTwoPi * (f.x * at.x + f.y * at.y));
  }
  if (config_.tilt) return sum;
  const Modes removed = all_modes(t_ns);
  for (int j = 0; j < kRemoved; ++j) sum -= removed[std::size_t(j)] * zernike(j, at);
  return sum;
}

Eigen::MatrixXf Turbulence::sample(Vec2 first, double step, int points, std::int64_t t_ns) const {
  // Matrix product: cos(a + b) = cos a cos b - sin a sin b separates x from y in each wave.
  const auto waves = Eigen::Index(waves_.size());
  Eigen::MatrixXf along_x(points, 2 * waves), along_y(2 * waves, points);
  for (Eigen::Index k = 0; k < waves; ++k) {
    const Wave& wave = waves_[std::size_t(k)];
    const Vec2 f = kTwoPi * wave.cycles_per_radius;
    std::complex<double> x = std::polar(1.0, f.x * first.x);
    std::complex<double> y = std::polar(wave.waves, f.y * first.y + phase_at_centre(wave, t_ns));
    const auto next_x = std::polar(1.0, f.x * step), next_y = std::polar(1.0, f.y * step);
    for (Eigen::Index p = 0; p < points; ++p, x *= next_x, y *= next_y) {
      along_x(p, 2 * k) = float(x.real());
      along_x(p, 2 * k + 1) = -float(x.imag());
      along_y(2 * k, p) = float(y.real());
      along_y(2 * k + 1, p) = float(y.imag());
    }
  }
  Eigen::MatrixXf sum = along_x * along_y;
  if (config_.tilt) return sum;
  const Modes removed = all_modes(t_ns);
  const Eigen::ArrayXf index = Eigen::ArrayXf::LinSpaced(points, 0.0F, float(points - 1));
  const auto tilt = [&](double slope, double start) {
    return (index * float(slope * step) + float(slope * start)).matrix().eval();
  };
  sum.array() -= float(removed[0]);
  sum.rowwise() -= tilt(zernike_gradient(1, {}).y * removed[1], first.y).transpose();
  sum.colwise() -= tilt(zernike_gradient(2, {}).x * removed[2], first.x);
  return sum;
}

}  // namespace ovws::twin
