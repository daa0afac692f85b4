#include "daemon/cli/refined.hpp"

#include <algorithm>
#include <cmath>

namespace ovws::cli {

bool RefinedModes::believable(const RefineCamera& camera) const {
  constexpr double kLeastPeak = 1.0;  // of the read noise: thousands of pixels share the light
  constexpr double kMostSigmaWaves = 0.1;
  constexpr double kMostChi2 = 3.0;  // the noise that a person states may be somewhat off
  const double most_sigma = *std::max_element(sigma_waves.begin(), sigma_waves.end());
  return peak_e > kLeastPeak * std::max(camera.read_noise_e, 1.0) && most_sigma < kMostSigmaWaves &&
         chi2_per_pixel < kMostChi2;
}

Result<RefinedMeasurement> RefinedMeasurement::make(const Config& config, const ImageView& like,
                                                    const std::optional<ImageView>& reference,
                                                    const std::vector<int>& modes_j,
                                                    const RefineCamera& camera) {
  auto refiner = Refiner::make(config.sensor, config.slm.geometry, config.optics, like.width,
                               like.height, modes_j);
  if (!refiner) return fail(refiner.error());
  RefinedMeasurement made(std::move(*refiner), camera, modes_j.size());
  if (!reference) return made;
  const std::vector<float> flat(modes_j.size(), 0.0F);
  auto refined = made.measure(*reference, flat);
  if (!refined) {
    return fail(refined.error().code, "reference",
                "the reference image cannot be refined: " + refined.error().reason);
  }
  made.reference_ = std::move(*refined);
  return made;
}

Result<RefinedModes> RefinedMeasurement::measure(const ImageView& image,
                                                 std::span<const float> start) {
  std::vector<double> from(start.size(), 0.0);
  for (std::size_t k = 0; k < from.size(); ++k) {
    from[k] = reference_.waves[k] + (std::isfinite(start[k]) ? double(start[k]) : 0.0);
  }
  const auto found = refiner_.refine(image, camera_, from);
  if (!found) return fail(found.error());
  RefinedModes out;
  out.chi2_per_pixel = found->chi2_per_pixel;
  out.peak_e = found->peak_e;
  for (std::size_t k = 0; k < from.size(); ++k) {
    out.waves.push_back(found->modes[k].waves - reference_.waves[k]);
    out.sigma_waves.push_back(std::hypot(found->sigma_waves[k], reference_.sigma_waves[k]));
  }
  return out;
}

}  // namespace ovws::cli
