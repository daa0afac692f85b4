/// Everything that a frame is measured with, prepared off the frame path and swapped whole at a
/// frame edge.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

/// Immutable once published.
struct MeasurementPlan {
  std::uint64_t id = 0;  ///< increases with each plan
  std::uint64_t sensor_epoch =
      0;  ///< changes when spots of older holograms no longer fit (charge, lattice, ROI)
  /// The hologram that predicted_px belongs to; 0: not said. Said, it lets the tracks follow a
  /// change of hologram exactly even if predictions changed for another reason (a reference)
  /// before.
  std::uint64_t hologram_id = 0;
  int charge = 1;
  TrackerKind tracker_kind = TrackerKind::lg;
  OperatorKind mode_operator = OperatorKind::slopes;  ///< whose inverse `reconstructor` is
  SpotModel spots;
  Roi roi;  ///< of the camera: what a frame must be an image of
  PixelFormat format = PixelFormat::mono8;
  /// Where each spot should be: reference, else model, moved by the aberration shown on purpose.
  std::vector<Vec2> predicted_px;
  /// Where to look for each spot without history; empty: at predicted_px.
  std::vector<Vec2> search_px;
  std::vector<Vec2> reference_px;  ///< what displacements count from; empty: no reference
  double reference_introduced_rms_waves = 0.0;  ///< aberration that the reference holds
  std::unique_ptr<const SpotTracker> tracker;
  std::unique_ptr<const Reconstructor> reconstructor;

  int subapertures() const { return int(predicted_px.size()); }
  const std::vector<Vec2>& places_px() const {
    return search_px.empty() ? predicted_px : search_px;
  }
  bool referenced() const { return !reference_px.empty(); }
};

}  // namespace ovws
