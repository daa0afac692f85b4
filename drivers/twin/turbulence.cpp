#include "drivers/twin/turbulence.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "core/optics/wavefront_rows.hpp"
#include "core/optics/zernike.hpp"
#include "drivers/twin/line_filter.hpp"

namespace ovws::twin {
namespace {

constexpr int kWaves = 300;
constexpr int kRemoved = 3;  ///< modes that `tilt: false` takes out: j = 0, 1, 2

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

Vec2 radii_per_s(const AirLayer& layer) {
  const double towards = layer.direction_deg * std::numbers::pi / 180.0;
  return 2.0 * layer.speed_pupils_per_s * Vec2{std::cos(towards), std::sin(towards)};
}

/// Fraction of a cycle that has passed since UTC 0. A double cannot resolve it over decades of
/// nanoseconds.
double fraction_of_cycle(long double cycles_per_s, std::int64_t t_ns) {
  const long double cycles = cycles_per_s * (long double)(t_ns)*1e-9L;
  return double(cycles - std::floor(cycles));
}

std::complex<double> power_of_i(int m) {
  constexpr std::array<std::complex<double>, 4> kPowers{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  return kPowers[std::size_t(m % 4)];
}

}  // namespace

Turbulence::Turbulence(const TurbulenceConfig& config) : config_(config), waves_(kWaves) {
  std::vector<AirLayer> layers = config.layers;
  if (layers.empty()) layers.push_back({1.0, config.speed_pupils_per_s, config.direction_deg});
  std::mt19937_64 random{std::uint64_t(config.seed)};
  const auto uniform = [&random] { return double(random() >> 11) * 0x1.0p-53; };
  const double lowest = std::log(0.25 / std::max(config.outer_scale_pupils, 1.0));
  const double highest = std::log(kMaxCycles);
  for (int k = 0; k < kWaves; ++k) {
    Wave& wave = waves_[std::size_t(k)];
    const AirLayer& layer = layers[std::size_t(k) % layers.size()];
    const double cycles = std::exp(lowest + (highest - lowest) * (k + uniform()) / kWaves);
    const double direction = kTwoPi * uniform();
    wave.cycles_per_radius = (0.5 * cycles) * Vec2{std::cos(direction), std::sin(direction)};
    wave.start_cycles = uniform();
    wave.radii_per_s = radii_per_s(layer);
    const double knee = 1.0 / config.outer_scale_pupils;
    // The power in a spectral ring of width d ln f is f^2 times the spectral density; the amplitude
    // is its square root.
    wave.waves =
        std::sqrt(layer.strength) * cycles * std::pow(cycles * cycles + knee * knee, -11.0 / 12.0);
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
  const long double cycles_per_s =
      (long double)(wave.cycles_per_radius.x) * (long double)(wave.radii_per_s.x) +
      (long double)(wave.cycles_per_radius.y) * (long double)(wave.radii_per_s.y);
  return kTwoPi * (wave.start_cycles - fraction_of_cycle(cycles_per_s, t_ns));
}

Turbulence::Modes Turbulence::vibration_modes(std::int64_t t_ns) const {
  Modes modes{};
  for (const Vibration& vibration : config_.vibrations) {
    modes[std::size_t(vibration.j)] +=
        std::numbers::sqrt2 * vibration.rms_waves *
        std::sin(kTwoPi * fraction_of_cycle(vibration.frequency_hz, t_ns));
  }
  return modes;
}

/// What is added to the plane waves: vibrations, and the opposite of piston and tilts without
/// `tilt`.
Turbulence::Modes Turbulence::added_modes(std::int64_t t_ns) const {
  Modes added = vibration_modes(t_ns);
  if (config_.tilt) return added;
  const Modes air = air_modes(t_ns);
  for (std::size_t j = 0; j < kRemoved; ++j) added[j] -= air[j];
  return added;
}

Turbulence::Modes Turbulence::air_modes(std::int64_t t_ns) const {
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
  Modes modes = air_modes(t_ns);
  const Modes added = added_modes(t_ns);
  std::transform(modes.begin(), modes.end(), added.begin(), modes.begin(), std::plus<>());
  return modes;
}

double Turbulence::waves(Vec2 at, std::int64_t t_ns) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) {
    const Vec2 f = wave.cycles_per_radius;
    sum += wave.waves * std::cos(phase_at_centre(wave, t_ns) + kTwoPi * (f.x * at.x + f.y * at.y));
  }
  const Modes added = added_modes(t_ns);
  for (int j = 0; j < kModes; ++j) sum += added[std::size_t(j)] * zernike(j, at);
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
    for (Eigen::Index p = 0; p < points; ++p, x = product(x, next_x), y = product(y, next_y)) {
      along_x(p, 2 * k) = float(x.real());
      along_x(p, 2 * k + 1) = -float(x.imag());
      along_y(2 * k, p) = float(y.real());
      along_y(2 * k + 1, p) = float(y.imag());
    }
  }
  LineFilter product_with_y;
  for (Eigen::Index y = 0; y < points; ++y) {
    product_with_y.append(0, {along_y.col(y).data(), std::size_t(2 * waves)});
  }
  Eigen::MatrixXf sum(points, points);
  product_with_y.apply({along_x.data(), points, points}, sum.data());
  std::vector<Mode> modes;
  for (int j = 0; const double added : added_modes(t_ns)) modes.push_back({j++, added});
  const WavefrontRows added(modes, (-1.0 / step) * first, 2.0 / step);
  Eigen::VectorXd line(points);
  for (int y = 0; y < points; ++y) {
    added.waves(y, 0, {line.data(), std::size_t(points)});
    sum.col(y) += line.cast<float>();
  }
  return sum;
}

}  // namespace ovws::twin
