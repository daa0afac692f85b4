/// The measurement plan: everything needed to measure a frame, prepared off the frame path and
/// swapped as a whole between two frames.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/port/camera.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

/// Immutable once published.
struct MeasurementPlan {
  std::uint64_t id = 0;  ///< increases with each plan
  std::uint64_t sensor_epoch =
      0;  ///< changes when spots of older holograms no longer fit (charge, lattice, ROI)
  /// The hologram that predicted_px belongs to; 0: not given. With it the tracks follow a change of
  /// hologram exactly, even if a new reference has changed the predictions before.
  std::uint64_t hologram_id = 0;
  int charge = 1;
  TrackerKind tracker_kind = TrackerKind::lg;
  OperatorKind mode_operator = OperatorKind::slopes;  ///< `reconstructor` is its inverse
  SpotModel spots;
  Roi roi;  ///< the camera's ROI, which a frame must have
  PixelFormat format = PixelFormat::mono8;
  /// Expected spot positions: those of the reference (else model) plus the introduced aberration.
  std::vector<Vec2> predicted_px;
  std::vector<Vec2> reference_px;               ///< zero of the displacements; empty: no reference
  double reference_introduced_rms_waves = 0.0;  ///< introduced aberration in the reference
  /// Templates are to come: until then positions count only where they were followed.
  bool awaits_templates = false;
  bool fits_shapes = false;  ///< frames are to be measured by templates
  std::unique_ptr<const SpotTracker> tracker;
  std::vector<int> modes_j;  ///< that frames are measured in
  /// For the leading modes, which positions determine: all, unless templates determine more.
  std::unique_ptr<const Reconstructor> reconstructor;
  /// Templates about an operating point, of `modes_j`: measures a frame near that point from all
  /// its pixels, without the tracker. Null: none yet.
  std::shared_ptr<const FrameFit> fit;

  int subapertures() const { return int(predicted_px.size()); }
  bool referenced() const { return !reference_px.empty(); }
  /// Whether the spots' positions determine all modes.
  bool positions_suffice() const { return reconstructor->modes_j().size() == modes_j.size(); }
  bool wants_templates() const { return fits_shapes && referenced(); }
};

}  // namespace ovws
