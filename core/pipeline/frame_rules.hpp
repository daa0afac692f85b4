/// What may be said of a frame: from its times which hologram and which settings it is of, from its
/// spots whether a wavefront explains them.
#pragma once

#include <cstdint>
#include <span>

#include "core/pipeline/frame_record.hpp"

namespace ovws {

struct SettingsVerdict {
  bool known = false;  ///< false: the exposure overlaps a change, or nothing was ever applied
  double gain_db = 0.0, gain_raw = kNotKnown;  ///< see CameraSettings
  double exposure_us = 0.0;
  /// Earliest CLOCK_MONOTONIC time at which the exposure can have begun: arrival - exposure -
  /// transfer; with unknown settings, of the longer exposure of the two.
  std::int64_t exposure_begin_mono_ns = 0;
};

/// New values if the exposure began at or after the end of their write; previous values if it began
/// at or after the end of theirs, and the frame arrived at or before the begin of the new write.
SettingsVerdict judge_settings(const AppliedSettings& settings, std::int64_t arrival_mono_ns);

/// Whether the frame, against the quickest of its stream (ArrivalClock), came later by more than
/// the transfer may take and max(3 frame periods, 50 ms): it tells of a past that nobody should act
/// on. Never with a camera that gives no stamps. RT-safe.
bool is_late(const AppliedSettings& settings, std::int64_t arrival_mono_ns,
             std::int64_t unhindered_mono_ns) OVWS_NONBLOCKING;

struct HologramVerdict {
  std::uint64_t hologram_id = 0;
  bool still = false;    ///< the hologram stood still for the whole exposure
  bool settled = false;  ///< still, and fits the plan
};

/// The current hologram if it had settled when the exposure began; the previous one if that had,
/// and the frame arrived before the change began; otherwise the current one, not settled.
HologramVerdict judge_hologram(const ShownHologram& shown, std::uint64_t plan_sensor_epoch,
                               std::int64_t exposure_begin_mono_ns, std::int64_t arrival_mono_ns);

/// Residual up to which a frame's spots are all believed, lambda/d: above, outliers are looked for
/// (Reconstructor::solve_without_outliers).
constexpr double kCredibleResidual = 0.03;

/// Whether some wavefront of the modes reconstructed explains where the spots are: at most a sixth
/// of those with a reference is lost, and the fit residual is below 0.25 lambda/d, or below 0.045
/// lambda/d if a spot is lost or one of quality below 0.65 is among them, which may be the wrong
/// half of a split one. Added to either in quadrature: twice what the least exact tracker makes of
/// the pixels' noise, 1.25 px RMS(noise / level).
///
/// Measured with every tracker, 5 and 7 subapertures across, SNR 2 to 22, 2 waves of astigmatism
/// and of defocus, 0.3 and 0.5 wave RMS of j = 3 to 18. Right spots leave up to 0.055 lambda/d by
/// their interference, up to 0.034 if one is of low quality (plain centroid at 7 across: 0.052, and
/// modes wrong by 0.1 wave). Spots in wrong halves leave 0.01 to 0.15: a sixth (5 across) to a half
/// (7) of such frames is refused, the others the modes explain too well. Modes beyond those
/// reconstructed leave 0.07 for Kolmogorov turbulence of D/r0 = 2, where all spots are whole, and
/// 0.22 for 8, where some are not. With 13 spots of 19 a wrong one hides: the modes then explain it
/// to 0.006 lambda/d, and are wrong by 0.2 wave (charge 0 after sudden changes of 0.3 to 1.2 wave
/// RMS: one in seven of the frames with more than a sixth lost). What remains wrong with fewer lost
/// is in daemon/guide/accuracy.md. RT-safe.
bool is_explained(const Reconstruction& found, std::span<const SpotFix> spots,
                  double lambda_d_px) OVWS_NONBLOCKING;

}  // namespace ovws
