/// The record of one frame in the pipeline: timestamps, settings, spots and modes.
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

/// The current and the previous hologram on the SLM, with the times that assign frames to them. The
/// display's thread writes it twice per change: before the call that presents, with
/// t_settled_mono_ns = kNever, and after it. A frame exposed in between thus belongs to neither.
struct ShownHologram {
  struct One {
    std::uint64_t hologram_id = 0;       ///< 0: none
    std::uint64_t sensor_epoch = 0;      ///< 0: not a sensor hologram, nothing to measure
    std::int64_t t_begin_mono_ns = 0;    ///< time before the call that presents it
    std::int64_t t_settled_mono_ns = 0;  ///< presented + settle time
  };
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  One current;
  One previous;
  bool healthy = false;  ///< false: display fault, what it shows is unknown
};

/// Current and previous gain and exposure, with the times of the change. A frame whose exposure
/// overlaps the change belongs to neither. The camera's thread writes it twice per change: before
/// the device is written, with t_write_end_mono_ns = ShownHologram::kNever, and after that.
struct AppliedSettings {
  double gain_db = 0.0, exposure_us = 0.0, frame_rate_hz = 0.0;
  double previous_gain_db = 0.0, previous_exposure_us = 0.0;
  double gain_raw = kUnknownGain, previous_gain_raw = kUnknownGain;  ///< see CameraSettings
  Roi roi;                                  ///< does not change within one stream
  std::int64_t t_previous_end_mono_ns = 0;  ///< end of the write of the previous values
  std::int64_t t_write_begin_mono_ns = 0;
  std::int64_t t_write_end_mono_ns = 0;
  std::int64_t transfer_ns = 0;  ///< longest time from end of exposure to arrival: transfer_ms
};

/// Start position for tracking one spot.
struct SpotStart {
  Vec2 at_px;          ///< NaN: the spot was never found
  bool fresh = false;  ///< found in the last settled frame; else the position is only a hint
};

/// Preallocated and reused: the vectors have kMaxSubapertures and kMaxModes elements, of which
/// `spot_count` and `mode_count` are in use.
struct FrameRecord {
  GrabbedFrame frame;  ///< its pixels are valid only where requested (image, recording)
  const MeasurementPlan* plan =
      nullptr;  ///< valid while a record refers to it (Pipeline::oldest_plan_in_use)
  /// Frames missing since the previous published record. After a restart of the stream: the number
  /// that the frame rate would have given in the meantime.
  std::uint64_t gap = 0;
  std::uint64_t hologram_id = 0;
  bool still = false;           ///< hologram_id was settled during the whole exposure; not late
  bool settled = false;         ///< still, and the hologram is the sensor that the plan measures
  bool settings_known = false;  ///< gain and exposure are certain for this frame
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;

  std::uint64_t number = 0;    ///< sequence number of published records, from 1
  bool pixels_missed = false;  ///< pixels were to be recorded, but too many buffers were lent

  std::vector<SpotStart> starts;  ///< where tracking of each spot started
  std::vector<SpotFix> spots;
  int spot_count = 0;
  int tracked = 0;
  bool searched = false;            ///< the whole image was searched for spots, too
  float saturated_fraction = 0.0F;  ///< fraction of the spots with a saturated pixel
  /// RMS-normalised waves, order of plan->modes_j; NaN: neither positions nor templates give it.
  std::vector<float> coefficients;
  /// Standard errors of the coefficients, waves; NaN unless it is measured by templates.
  std::vector<float> sigma_waves;
  int mode_count = 0;
  /// How the plan's templates describe the frame; if `credible`, it is measured by them.
  FittedFrame templates;
  /// Settled, and measured by templates, or its spots were followed from such a frame in small
  /// steps (SpotHistory).
  bool follows = false;
  Reconstruction reconstruction;
  /// A wavefront explains the spots, but the plan has or awaits templates and the frame does not
  /// follow, or positions do not determine all modes.
  bool unconfirmed = false;
  bool explained = true;  ///< false: otherwise valid, but no wavefront explains the spots, or the
                          ///< frame is unconfirmed
  bool valid = false;     ///< settled, has a reference, modes determined, spots explained

  std::int64_t t_tracked_mono_ns = 0;
  std::int64_t t_reconstructed_mono_ns = 0;
};

}  // namespace ovws
