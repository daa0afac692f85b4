#include "drivers/twin/judge.hpp"

#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "drivers/twin/wavefront_fit.hpp"

namespace ovws::twin {
namespace {

/// Modes with index j >= `first`.
std::vector<Mode> tail(const std::vector<Mode>& modes, int first) {
  return {modes.begin() + first, modes.end()};
}

Eigen::VectorXd sum_of(const PupilBlocks& blocks, const std::vector<Mode>& modes) {
  Eigen::VectorXd waves = Eigen::VectorXd::Zero(blocks.count());
  for (const Mode& mode : modes) waves += mode.waves * blocks.modes().col(mode.j);
  return waves;
}

double rms(const PupilBlocks& blocks, const Eigen::VectorXd& waves) {
  const Eigen::VectorXd& weights = blocks.weights();
  const double mean = weights.dot(waves) / weights.sum();
  return std::sqrt(weights.dot((waves.array() - mean).square().matrix()) / weights.sum());
}

/// Strehl ratio |sum A exp(i phi)|^2 / (sum A)^2, phi being the modes plus `residual`.
double strehl(const PupilBlocks& blocks, std::vector<Mode> modes, const Eigen::VectorXd& residual) {
  for (Mode& mode : modes) mode.waves = -mode.waves;
  const Eigen::VectorXcd sums = blocks.sums(nullptr, modes);
  std::complex<double> sum = 0.0;
  for (Eigen::Index b = 0; b < sums.size(); ++b) {
    sum += sums[b] * unit_phasor(residual[b]);
  }
  return std::norm(sum / blocks.weights().sum());
}

}  // namespace

Judge::Judge(const Config& config) : config_(config), slm_(config), light_(config.truth) {}

const Judge::Expected& Judge::expected(Pattern pattern) {
  std::unique_ptr<Expected>& cached = expected_[std::size_t(pattern)];
  if (cached) return *cached;
  Image<std::complex<float>> ideal = ideal_hologram(config_, pattern);
  Image<float> amplitude(ideal.width, ideal.height);
  for (int y = 0; y < amplitude.height; ++y) {
    for (int x = 0; x < amplitude.width; ++x) {
      if (ideal.at(x, y) != std::complex<float>{}) amplitude.at(x, y) = slm_.amplitude(x, y);
    }
  }
  const Vec2 centre{(amplitude.width - 1) / 2.0, (amplitude.height - 1) / 2.0};
  cached = std::make_unique<Expected>(
      Expected{std::move(ideal),
               PupilBlocks(std::move(amplitude), centre, config_.sensor.pupil_diameter_px)});
  return *cached;
}

std::optional<Verdict> Judge::judge(Pattern pattern, const Image<std::uint8_t>& grey,
                                    const Light& light, const Turbulence* turbulence,
                                    std::int64_t t_ns) {
  const auto& [ideal, blocks] = expected(pattern);
  if (!(light == light_)) slm_.set_light(light);
  light_ = light;
  slm_.set_turbulence(turbulence, t_ns);
  Image<std::complex<float>> field(grey.width, grey.height);
  slm_.modulate(grey, 0, grey.height, field);
  for (std::size_t i = 0; i < field.pixels.size(); ++i) {
    field.pixels[i] = product(field.pixels[i], std::conj(ideal.pixels[i]));
  }
  const WavefrontFit fit = fit_wavefront(blocks, field);
  if (!fit.unwrapped) return std::nullopt;
  const auto beyond_piston = tail(fit.modes, 1), beyond_tilt = tail(fit.modes, 3);
  const std::complex<double> coherent =
      blocks.sums(&field, fit.modes).sum() / blocks.weights().sum();
  return Verdict{fit.modes,
                 rms(blocks, sum_of(blocks, beyond_tilt) + fit.residual_waves),
                 rms(blocks, sum_of(blocks, beyond_piston) + fit.residual_waves),
                 strehl(blocks, beyond_tilt, fit.residual_waves),
                 strehl(blocks, beyond_piston, fit.residual_waves),
                 std::norm(coherent)};
}

std::optional<std::vector<Mode>> Judge::flatness_modes() {
  const PupilBlocks& blocks = expected(Pattern::grating).blocks;
  const Image<float>& surface = slm_.surface_waves();
  const SlmGeometry& slm = config_.slm.geometry;
  Image<std::complex<float>> field(slm.width_px, slm.height_px, 1.0F);
  for (int y = 0; y < surface.height; ++y) {
    for (int x = 0; x < surface.width; ++x) {
      field.at(x, y) =
          std::polar(slm_.amplitude(x, y), float(2.0 * std::numbers::pi) * surface.at(x, y));
    }
  }
  const WavefrontFit fit = fit_wavefront(blocks, field);
  if (!fit.unwrapped) return std::nullopt;
  return fit.modes;
}

std::array<double, 256> Judge::lut_waves(const SlmConfig& slm) {
  std::array<double, 256> waves{};
  for (std::size_t g = 0; g < waves.size(); ++g) waves[g] = slm_phase_waves(slm, int(g));
  return waves;
}

}  // namespace ovws::twin
