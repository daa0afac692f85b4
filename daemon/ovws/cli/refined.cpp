#include "daemon/ovws/cli/refined.hpp"

#include <cmath>

namespace ovws::cli {

Result<RefinedMeasurement> RefinedMeasurement::make(const Config& config, const ImageView& like,
                                                    const std::optional<ImageView>& reference,
                                                    const std::vector<int>& modes_j,
                                                    const RefineCamera& camera,
                                                    const RefineOptions& fit) {
  auto refiner = Refiner::make(config.sensor, config.slm.geometry, config.optics, like.width,
                               like.height, modes_j, fit);
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
  return minus(refined_modes(*found), reference_);
}

}  // namespace ovws::cli
