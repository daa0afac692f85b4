#include "core/optics/detector.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/optics/noise.hpp"

namespace ovws {
namespace {

constexpr std::uint64_t kResponseStream = 0;  ///< noise stream for PRNU; exposures use 1, 2, …

double full_scale_dn(const DetectorConfig& config) {
  return (1 << std::clamp(config.bits, 1, 16)) - 1;
}

}  // namespace

double dn_per_electron(const DetectorConfig& config, double gain_db) {
  return full_scale_dn(config) / config.full_well_e * std::pow(10.0, gain_db / 20.0);
}

Detector::Detector(const DetectorConfig& config, int width, int height)
    : config_(config), width_(width), height_(height) {
  assert(width > 0 && height > 0);
  Noise noise(config.seed, kResponseStream);
  response_.resize(std::size_t(width) * height);
  for (float& pixel : response_) {
    const double gain = 1.0 + config.prnu * static_cast<double>(noise.normal());
    pixel = static_cast<float>(config.quantum_efficiency * std::max(0.0, gain));
  }
}

void Detector::expose(const Image<float>& photons, double exposure_us, double gain_db,
                      Image<std::uint16_t>& dn) {
  assert(photons.width == width_ && photons.height == height_);
  dn.width = width_;
  dn.height = height_;
  dn.pixels.resize(response_.size());
  const auto dark_e = static_cast<float>(config_.dark_current_e_per_s * exposure_us * 1e-6);
  mean_e_.resize(response_.size());
  using Values = Eigen::Map<const Eigen::ArrayXf>;
  const auto count = Eigen::Index(response_.size());
  Eigen::Map<Eigen::ArrayXf>(mean_e_.data(), count) =
      Values(photons.pixels.data(), count) * Values(response_.data(), count) + dark_e;
  const PixelChain chain{.shot_noise = config_.shot_noise,
                         .read_noise_e = static_cast<float>(config_.read_noise_e),
                         .full_well_e = static_cast<float>(config_.full_well_e),
                         .dn_per_e = static_cast<float>(dn_per_electron(config_, gain_db)),
                         .black_dn = static_cast<float>(config_.black_level_dn),
                         .top_dn = static_cast<float>(full_scale_dn(config_))};
  Noise::expose(config_.seed, ++realisation_, chain, mean_e_, dn.pixels.data());
}

}  // namespace ovws
