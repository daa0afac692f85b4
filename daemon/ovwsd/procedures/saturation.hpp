/// Measurements of single spots at whatever exposure the camera has.
#pragma once

#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// The error of a measurement whose spot is saturated: Errc::refused, field "camera.exposure_us".
/// It is recognised by its reason, which must not be changed on the way.
Error saturated_spot();
bool is_saturated_spot(const Error& error);

/// Number of saturated spots in a mean image of spots `pitch_px` apart, wherever they are: groups
/// of saturated (not finite) pixels at most 0.65 pitches long. A saturated pixel without another
/// one beside it is taken for a hot pixel.
int count_saturated_spots(const Image<float>& mean_dn, double pitch_px);

/// Changes the exposure by this factor for the rest of the job, within the camera's limits and the
/// frame period. Returns false if it is there already. Errors: those of Bench::set_camera.
Result<bool> change_exposure(Bench& bench, double factor);

/// Factor from one exposure to the next of a search for one at which a spot can be measured.
constexpr double kExposureStep = 4.0;
constexpr int kMaxExposureSteps = 6;

/// The result of `measure`, which is repeated with a shorter exposure as long as its spot is
/// saturated.
template <class Measure>
auto unsaturated(Bench& bench, const Measure& measure) -> decltype(measure()) {
  for (int steps = 0;; ++steps) {
    auto measured = measure();
    if (measured || !is_saturated_spot(measured.error()) || steps == kMaxExposureSteps) {
      return measured;
    }
    const auto changed = change_exposure(bench, 1.0 / kExposureStep);
    if (!changed) return fail(changed.error());
    if (!*changed) return measured;
  }
}

}  // namespace ovws
