/// What may be said of a frame from its times alone: which hologram and which settings it is of.
#pragma once

#include <cstdint>

#include "core/pipeline/frame_record.hpp"

namespace ovws {

struct SettingsVerdict {
  bool known = false;  ///< false: the exposure overlaps a change, or nothing was ever applied
  double gain_db = 0.0;
  double exposure_us = 0.0;
  /// Earliest CLOCK_MONOTONIC time at which the exposure can have begun: arrival - exposure -
  /// transfer; with unknown settings, of the longer exposure of the two.
  std::int64_t exposure_begin_mono_ns = 0;
};

/// New values if the exposure began at or after the end of their write; previous values if it began
/// at or after the end of theirs, and the frame arrived at or before the begin of the new write.
SettingsVerdict judge_settings(const AppliedSettings& settings, std::int64_t arrival_mono_ns);

struct HologramVerdict {
  std::uint64_t hologram_id = 0;
  bool still = false;    ///< the hologram stood still for the whole exposure
  bool settled = false;  ///< still, and fits the plan
};

/// The current hologram if it had settled when the exposure began; the previous one if that had,
/// and the frame arrived before the change began; otherwise the current one, not settled.
HologramVerdict judge_hologram(const ShownHologram& shown, std::uint64_t plan_sensor_epoch,
                               std::int64_t exposure_begin_mono_ns, std::int64_t arrival_mono_ns);

}  // namespace ovws
