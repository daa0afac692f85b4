/// The interface of a spot tracker: one spot of one frame, from a start position.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// The operator that reconstructs modes from spot displacements.
enum class OperatorKind : std::uint8_t {
  slopes,    ///< geometric: each mode's tilt as the tracker weights it (slope_matrix)
  measured,  ///< each mode poked on the bench and tracked (interaction_matrix)
};

/// Tracking settings: TrackingConfig plus the settings of the mode reconstruction.
struct TrackingSettings : TrackingConfig {
  OperatorKind mode_operator = OperatorKind::slopes;
  /// Number of modes to measure, from j = 1 on. None: as many as spot positions determine; a larger
  /// number requires templates.
  std::optional<int> mode_count = std::nullopt;
  int estimates = 8;  ///< number of estimates per spot, tracker `fit`

  friend bool operator==(const TrackingSettings&, const TrackingSettings&) = default;
};

/// Properties of the spots that a tracker needs. Lengths in camera pixels.
struct SpotModel {
  int charge = 1;
  double lambda_d_px = 12.55;  ///< diffraction scale of one subaperture on the camera
  LitPixels lit{};             ///< the camera pixels that receive the spots' light

  /// The same spots in an image of the lit colour plane alone, whose pixels are `lit.plane.step`
  /// camera pixels apart.
  SpotModel on_plane() const { return {charge, lambda_d_px / lit.plane.step}; }

  friend bool operator==(const SpotModel&, const SpotModel&) = default;
};

/// Working memory of one tracking thread, sized once: `track` never allocates.
struct TrackScratch {
  std::vector<float> samples;
  std::vector<float> sums;
};

/// Spot tracker, immutable after construction. All threads share one object; each thread has its
/// own scratch memory.
class SpotTracker {
 public:
  virtual ~SpotTracker() = default;

  virtual TrackScratch make_scratch() const = 0;

  /// Finds the spot near `start_px`. The fix is lost (see SpotFix) if the pixels do not look like a
  /// spot; a tracker never returns a guess. The window is clipped at the image's edge, and a spot
  /// too near the edge is lost. RT-safe, except for lg_contour and PositionFit, which allocate.
  virtual SpotFix track(const ImageView& image, Vec2 start_px,
                        TrackScratch& scratch) const OVWS_NONBLOCKING = 0;
};

/// Makes a tracker. For `fit` it is `lg`, which finds spots while no templates apply. Positions are
/// camera pixels, even if only one colour plane is lit (see plane_tracker.hpp).
///
/// Errors (Errc::invalid), by field: "tracking.kernel_radius" outside [0.1, 2]; "tracking.tracker":
/// a tracker of the centroid family, but the charge is not 0; "sensor.charge" outside [-8, 8];
/// "optics": lambda/d below 3.5 or above 200 lit pixels.
Result<std::unique_ptr<const SpotTracker>> make_tracker(const TrackingConfig& config,
                                                        const SpotModel& spots);

}  // namespace ovws
