#include "core/optics/detector.hpp"

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
  Noise noise(config_.seed, ++realisation_);
  const auto dark_e = static_cast<float>(config_.dark_current_e_per_s * exposure_us * 1e-6);
  const auto full_well_e = static_cast<float>(config_.full_well_e);
  const auto read_noise_e = static_cast<float>(config_.read_noise_e);
  const auto gain = static_cast<float>(dn_per_electron(config_, gain_db));
  const auto black_dn = static_cast<float>(config_.black_level_dn);
  const auto top_dn = static_cast<float>(full_scale_dn(config_));
  for (std::size_t i = 0; i < response_.size(); ++i) {
    const float mean_e = photons.pixels[i] * response_[i] + dark_e;
    const float collected_e = config_.shot_noise ? noise.poisson(mean_e) : mean_e;
    const float read_e = std::min(full_well_e, collected_e) + read_noise_e * noise.normal();
    // NaN: with this order of arguments, std::max returns 0 and the pixel is black.
    const float level = std::min(top_dn, std::max(0.0F, read_e * gain + black_dn));
    dn.pixels[i] = static_cast<std::uint16_t>(level + 0.5F);
  }
}

}  // namespace ovws
