/// An arm of the gain sweep as a sensor: measures images of the bench by the positions of their
/// spots.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovws/study/gain_sweep.hpp"

namespace ovws::study {

/// Spots of one image, one per subaperture.
struct SweepFrame {
  double saturated_fraction = 0.0;  ///< fraction of the spots with a saturated pixel
  std::vector<SpotFix> spots;
};

/// Mean position of each spot; NaN: it is found in less than half of the frames.
std::vector<Vec2> mean_positions(std::span<const SweepFrame> frames);
SpotLevels levels_of(std::span<const SweepFrame> frames);
/// The modes of each frame, and what is left of them without those that were `introduced`.
std::vector<CellMeasured::Frame> judge_frames(std::span<const SweepFrame> frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced);

/// Not thread-safe.
class SweepSensor {
 public:
  /// `bench`: the daemon's configuration in use, with the registration of its camera. All
  /// subapertures have the arm's charge. Errors: those of make_lattice and make_tracker.
  static Result<SweepSensor> make(const SweepArm& arm, const Config& bench);

  /// Takes the reference from images without an aberration. `starts_px`: where their spots are, one
  /// per subaperture. Errc::refused, field "camera.exposure_us": spots are saturated, or lost.
  Result<ReferenceMeasured> take_reference(std::span<const ImageView> images,
                                           std::span<const Vec2> starts_px);
  /// Measures the images of a cell, after the reference was taken.
  void measure(std::span<const ImageView> images, std::span<const Vec2> starts_px,
               const std::vector<Mode>& introduced, CellMeasured& cell);

 private:
  SweepSensor() = default;
  std::vector<SweepFrame> find(std::span<const ImageView> images, std::span<const Vec2> starts_px);

  SweepArm arm_;
  std::shared_ptr<const SpotTracker> tracker_;
  TrackScratch scratch_;
  ModeOperator model_;
  std::vector<Vec2> cells_px_;  ///< centres of the fixed windows; empty: there are none
  std::optional<Reconstructor> reconstructor_;
};

}  // namespace ovws::study
