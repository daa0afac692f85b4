/// One frame on its way through the pipeline, and what was measured of it.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/pipeline/plan.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/spot.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

constexpr int kMaxModes = kMaxZernikeIndex;  ///< j = 1 .. kMaxZernikeIndex

/// What the SLM showed, as the frame path needs it. The display's thread writes it twice a change:
/// before the call that presents, with t_settled_mono_ns = kNever, and again when it has presented;
/// else a frame exposed meanwhile would pass for one of the hologram before.
struct ShownHologram {
  struct One {
    std::uint64_t hologram_id = 0;       ///< 0: none
    std::uint64_t sensor_epoch = 0;      ///< 0: not a sensor hologram, nothing to measure
    std::int64_t t_begin_mono_ns = 0;    ///< before the call that presents it
    std::int64_t t_settled_mono_ns = 0;  ///< presented + settle time
  };
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  One current;
  One previous;
  bool healthy = false;  ///< false: the display is at fault, nothing is known to be shown
};

/// The settings that changed last; a frame whose exposure straddles the change belongs to neither.
/// The camera's thread writes it twice a change: before the device is written, with
/// t_write_end_mono_ns = ShownHologram::kNever, and again when it has been.
struct AppliedSettings {
  double gain_db = 0.0, exposure_us = 0.0, frame_rate_hz = 0.0;
  double previous_gain_db = 0.0, previous_exposure_us = 0.0;
  double gain_raw = kNotKnown, previous_gain_raw = kNotKnown;  ///< see CameraSettings
  Roi roi;                                  ///< does not change within one stream
  std::int64_t t_previous_end_mono_ns = 0;  ///< the write of the previous values had ended
  std::int64_t t_write_begin_mono_ns = 0;
  std::int64_t t_write_end_mono_ns = 0;
  std::int64_t transfer_ns = 0;  ///< longest time from end of exposure to arrival, by configuration
};

/// Where to look for one spot.
struct SpotStart {
  Vec2 at_px;          ///< NaN: it was never found
  bool fresh = false;  ///< it was found in the last settled frame; else the position is only a hint
};

/// Preallocated and reused: vectors are sized for kMaxSubapertures and kMaxModes once, `…_count`
/// says how much is used.
struct FrameRecord {
  GrabbedFrame frame;  ///< its pixels are lent only to who asked for the image
  const MeasurementPlan* plan =
      nullptr;  ///< lives as long as a record refers to it (Pipeline::oldest_plan_in_use)
  /// Frames missing since the published record before; over a stream begun anew as many as the
  /// frame rate would have given meanwhile.
  std::uint64_t gap = 0;
  std::uint64_t hologram_id = 0;
  bool still = false;           ///< that hologram stood still for the whole exposure; not late
  bool settled = false;         ///< still, and it is the sensor's that the plan is for
  bool settings_known = false;  ///< gain and exposure are of this very frame
  double gain_db = 0.0, gain_raw = kNotKnown;  ///< see CameraSettings
  double exposure_us = 0.0;

  std::uint64_t number = 0;    ///< of published records, from 1
  bool pixels_missed = false;  ///< its pixels were to be recorded, and too many were lent already

  std::vector<SpotStart> starts;  ///< where each spot was looked for at first
  std::vector<SpotFix> spots;
  int spot_count = 0;
  int tracked = 0;
  bool searched = false;            ///< its spots were looked for in the whole image, too
  float saturated_fraction = 0.0F;  ///< of the spots
  std::vector<float>
      coefficients;  ///< RMS-normalised waves, order of plan->reconstructor->modes_j()
  int mode_count = 0;
  Reconstruction reconstruction;
  bool explained = true;  ///< false: no wavefront explains the spots of a frame else valid
  bool valid = false;     ///< settled, referenced, the modes are determined, the spots explained

  std::int64_t t_tracked_mono_ns = 0;
  std::int64_t t_reconstructed_mono_ns = 0;
};

}  // namespace ovws
