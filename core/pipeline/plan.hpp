/// The measurement plan: everything needed to measure a frame, prepared off the frame path and
/// swapped as a whole between two frames.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/dmd.hpp"
#include "core/optics/zernike.hpp"
#include "core/port/camera.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/tracking/spot_kinds.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/branch_points.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

/// Further light sources on the camera, besides the main one.
constexpr int kMaxBeams = 4;

/// The cycle of binary images that a DMD plays. Slot 0 is dark: the mark. Slot s shows pattern
/// (s - 1) modulo the number of patterns.
struct PatternCycle {
  int slots = 0;               ///< 2 to kMaxPatternSlots
  std::int64_t period_ns = 0;  ///< of one slot

  friend bool operator==(const PatternCycle&, const PatternCycle&) = default;
};

/// Measurement plan; immutable once the frame path may use it.
struct MeasurementPlan {
  std::uint64_t id = 0;  ///< increases with each plan
  /// Changes when spots of older holograms no longer fit: with charge, lattice, LUT, flatness,
  /// registration, camera or ROI.
  std::uint64_t sensor_epoch = 0;
  /// The hologram for which predicted_px was computed; no frame of a newer one is settled. Spot
  /// tracks need it to follow a change of hologram exactly, even if a new reference changed the
  /// predictions before.
  std::uint64_t hologram_id = 0;
  std::vector<Mode> correction;  ///< in that hologram: subtracted, RMS-normalised waves
  int charge = 1;
  TrackerKind tracker_kind = TrackerKind::lg;
  OperatorKind mode_operator = OperatorKind::slopes;  ///< inverted by `reconstructor`
  SpotModel spots;
  Roi roi;  ///< camera ROI; frames with another ROI are not valid
  PixelFormat format = PixelFormat::mono8;
  /// Expected spot positions, camera px: reference (or model) plus the introduced aberration.
  std::vector<Vec2> predicted_px;
  std::vector<Vec2> reference_px;               ///< zero of the displacements; empty: no reference
  double reference_introduced_rms_waves = 0.0;  ///< introduced aberration in the reference
  /// Templates are being prepared. Until they are ready, spot positions give valid frames only if
  /// the frame follows (FrameRecord::follows).
  bool awaits_templates = false;
  bool can_fit_shapes = false;  ///< whether templates can be made for these modes
  std::shared_ptr<const SpotTracker> tracker;
  /// Kinds of the spots, if they differ. Null: all are as `spots` and `tracker` say.
  std::shared_ptr<const SpotKinds> kinds;
  std::vector<int> modes_j;  ///< OSA indices of the measured modes
  /// Reconstructs the leading modes of `modes_j` from spot positions. These are all modes, unless
  /// templates determine more.
  std::shared_ptr<const Reconstructor> reconstructor;
  /// Recognises branch points of the light by spot positions; null: not looked for.
  std::shared_ptr<const BranchPoints> branch_points;
  /// Templates for `modes_j` about an operating point. They measure a frame near that wavefront
  /// from all its pixels, without the tracker. Null: not ready yet.
  std::shared_ptr<const FrameFit> fit;
  std::string beam;  ///< name of the light source that it measures; empty: the main one
  /// Part of the image in which spots without history are searched; none: the whole image.
  std::optional<Disc> region;
  /// Plans of the further sources, with the same id, sensor epoch, ROI and format; they have no
  /// templates. At most kMaxBeams.
  std::vector<std::shared_ptr<const MeasurementPlan>> beams;
  /// Plans of the patterns of a DMD's sequence, which differ from this one in their predicted
  /// positions: each measures the frames of its pattern, and this one measures none. They have
  /// neither beams nor templates. Empty: no sequence is shown. At most kMaxPatternSlots - 1.
  std::vector<std::shared_ptr<const MeasurementPlan>> patterns;
  PatternCycle cycle;  ///< of `patterns`

  int subapertures() const { return int(predicted_px.size()); }
  const SpotTracker& tracker_of(int spot) const OVWS_NONBLOCKING {
    return kinds ? kinds->tracker_of(spot) : *tracker;
  }
  /// As for drop_faint.
  std::span<const float> levels() const OVWS_NONBLOCKING {
    return kinds ? kinds->levels() : std::span<const float>{};
  }
  TrackScratch make_scratch() const {
    return kinds ? kinds->make_scratch() : tracker->make_scratch();
  }
  bool referenced() const { return !reference_px.empty(); }
  /// Whether the spots' positions determine all modes.
  bool positions_suffice() const { return reconstructor->modes_j().size() == modes_j.size(); }
  /// Whether frames shall be measured by templates. Other trackers use them only while they are
  /// lost in a closed loop (WavefrontSearch).
  bool wants_templates() const { return tracker_kind == TrackerKind::fit && may_use_templates(); }
  bool may_use_templates() const { return can_fit_shapes && referenced(); }
};

}  // namespace ovws
