/// The record of one frame in the pipeline: timestamps, settings, spots and modes.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/pipeline/plan.hpp"
#include "core/pipeline/position_modes.hpp"
#include "core/pipeline/verdict.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/spot.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

constexpr int kMaxModes = kMaxZernikeIndex;  ///< j = 1 .. kMaxZernikeIndex

/// Current and previous hologram on the SLM, with the times by which frames are assigned to them.
/// The display thread writes this struct twice per change: before the present call, with
/// t_settled_mono_ns = kNever, and after that call. A frame exposed in between is not settled.
struct ShownHologram {
  struct One {
    std::uint64_t hologram_id = 0;       ///< 0: none
    std::uint64_t sensor_epoch = 0;      ///< 0: not a sensor hologram, nothing to measure
    std::int64_t t_begin_mono_ns = 0;    ///< time just before the hologram is presented
    std::int64_t t_settled_mono_ns = 0;  ///< time of presentation + settle time of the SLM
    bool sequence = false;               ///< a DMD's sequence: MeasurementPlan::patterns
  };
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  One current;
  One previous;
  bool healthy = false;  ///< false: display fault; the hologram on the SLM is unknown
};

/// Current and previous gain and exposure, with the times of the change. A frame whose exposure
/// overlaps the change has unknown settings. The camera thread writes this struct twice per change:
/// before it writes to the device, with t_write_end_mono_ns = ShownHologram::kNever, and after
/// that.
struct AppliedSettings {
  double gain_db = 0.0, exposure_us = 0.0, frame_rate_hz = 0.0;
  double previous_gain_db = 0.0, previous_exposure_us = 0.0;
  double gain_raw = kUnknownGain, previous_gain_raw = kUnknownGain;  ///< see CameraSettings
  Roi roi;                                  ///< does not change within one stream
  std::int64_t t_previous_end_mono_ns = 0;  ///< end of writing the previous values to the camera
  std::int64_t t_write_begin_mono_ns = 0;
  std::int64_t t_write_end_mono_ns = 0;
  std::int64_t transfer_ns = 0;  ///< longest time from end of exposure to arrival (transfer_ms)
};

/// Start position for tracking one spot.
struct SpotStart {
  Vec2 at_px;          ///< NaN: the spot was never found
  bool fresh = false;  ///< true: found in the last settled frame; false: only a hint
};

/// What the measurements of all light sources in one frame have in common.
struct FrameStamp {
  GrabbedFrame frame;  ///< pixels are valid only if requested (image, recording)
  /// Number of frames missing since the previous published record. After a restart of the stream it
  /// is estimated from the elapsed time and the frame rate.
  std::uint64_t gap = 0;
  std::uint64_t hologram_id = 0;
  bool late = false;   ///< see is_late of frame_rules.hpp
  bool still = false;  ///< the hologram was settled during the whole exposure; not late
  /// Still, sensor epoch and ROI are those of the plan, the plan is not for an older hologram, and
  /// of a sequence the pattern is certain.
  bool settled = false;
  int pattern = -1;  ///< number of the sequence's pattern; -1: none is shown, or uncertain
  bool settings_known = false;                    ///< gain and exposure are certain for this frame
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;
  Roi roi;  ///< region of interest of the stream that the frame is from
  /// Estimated end of the exposure, CLOCK_MONOTONIC: the undelayed arrival less half of the longest
  /// transfer time.
  std::int64_t t_exposed_mono_ns = 0;
  std::int64_t transfer_ns = 0;  ///< longest time from end of exposure to arrival
  std::int64_t period_ns = 0;    ///< of the camera's frames when it was sent; 0: unknown

  std::uint64_t number = 0;    ///< sequence number of published records, from 1
  bool pixels_missed = false;  ///< pixels were to be recorded, but too many buffers were lent
};

/// Frame record, preallocated and reused. Its vectors have kMaxSubapertures or kMaxModes elements,
/// of which `spot_count` or `mode_count` are in use.
struct FrameRecord : FrameStamp {
  const MeasurementPlan* plan =
      nullptr;  ///< valid while a record refers to it (Pipeline::oldest_plan_in_use)
  std::vector<SpotStart> starts;  ///< where tracking of each spot started
  std::vector<SpotFix> spots;
  int spot_count = 0;
  int tracked = 0;
  bool searched = false;            ///< the whole image was searched for spots, too
  float saturated_fraction = 0.0F;  ///< fraction of the spots with a saturated pixel
  /// Zernike coefficients, RMS-normalised waves, in the order of plan->modes_j. NaN: neither spot
  /// positions nor templates determine the mode.
  std::vector<float> coefficients;
  /// Standard errors of the coefficients, waves; NaN unless the frame is measured by templates.
  std::vector<float> sigma_waves;
  int mode_count = 0;
  /// How well the plan's templates describe the frame. If `credible`, they give spots and modes.
  FittedFrame templates;
  /// The frame is settled and its spots can be trusted (SpotHistory): templates describe the frame,
  /// or every spot is near its place in the previous settled frame, which follows, or, while the
  /// plan awaits templates, near its place in the reference.
  bool follows = false;
  Reconstruction reconstruction;
  /// A wavefront explains the spots, but nothing confirms it. Either the plan has or awaits
  /// templates and the frame does not follow, or spot positions do not determine all modes.
  bool unconfirmed = false;
  /// Branch points of the light. Only looked for in frames that templates do not describe.
  FoundBranchPoints branch_points;
  bool explained = true;  ///< false: otherwise valid, but no wavefront explains the spots, or the
                          ///< frame is unconfirmed, or has branch points
  bool valid = false;     ///< settled, has a reference, modes determined, spots explained
  Verdict verdict = Verdict::changing;  ///< Verdict::valid if `valid`, else why not

  std::int64_t t_tracked_mono_ns = 0;
  std::int64_t t_reconstructed_mono_ns = 0;

  /// Memory for the further sources' measurements of this frame; see beams().
  std::vector<FrameRecord*> beam_records;

  /// The measurements of the further sources, in the order of plan->beams. Main record only.
  std::span<FrameRecord* const> beams() const {
    return std::span(beam_records).first(plan->beams.size());
  }
};

}  // namespace ovws
