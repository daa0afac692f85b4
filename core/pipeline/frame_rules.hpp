/// Frame validity rules: which hologram and settings a frame belongs to (from its times), and
/// whether a wavefront explains its spots (from the fit residual). Ingest applies the rules to set
/// `settled`, Pipeline to set `valid`.
#pragma once

#include <cstdint>
#include <span>

#include "core/pipeline/frame_record.hpp"

namespace ovws {

struct SettingsVerdict {
  bool known = false;  ///< false: the exposure overlaps a change, or nothing was applied yet
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;
  /// Earliest CLOCK_MONOTONIC time at which the exposure can have begun: arrival - exposure -
  /// transfer. If the settings are unknown, the longer of current and previous exposure counts.
  std::int64_t exposure_begin_mono_ns = 0;
};

/// Assigns camera settings to a frame. The current values apply if the exposure began after they
/// were written. The previous values apply if the exposure began after those were written and the
/// frame arrived before the next write began. Otherwise the settings are unknown.
SettingsVerdict judge_settings(const AppliedSettings& settings, std::int64_t arrival_mono_ns);

/// Whether a frame's delivery delay (arrival minus ArrivalClock's undelayed arrival) exceeds the
/// transfer time + max(3 frame periods, 50 ms): its data are too old for control. Never true for a
/// camera without timestamps. RT-safe.
bool is_late(const AppliedSettings& settings, std::int64_t arrival_mono_ns,
             std::int64_t undelayed_mono_ns) OVWS_NONBLOCKING;

struct HologramVerdict {
  std::uint64_t hologram_id = 0;
  bool still = false;     ///< the hologram was settled during the whole exposure
  bool settled = false;   ///< still, and the hologram is of the plan's sensor epoch
  bool sequence = false;  ///< see ShownHologram::One
};

/// Assigns a hologram to a frame. The current hologram if it had settled before the exposure began.
/// The previous hologram if it had settled before the exposure and the exposure was over before the
/// change began: `arrival_mono_ns`, the arrival without delay (ArrivalClock). Otherwise, or with a
/// display fault, the current hologram, not settled.
HologramVerdict judge_hologram(const ShownHologram& shown, std::uint64_t plan_sensor_epoch,
                               std::int64_t exposure_begin_mono_ns, std::int64_t arrival_mono_ns);

/// RMS fit residual in lambda/d above which outliers among the spots are rejected
/// (Reconstructor::solve_without_outliers).
constexpr double kCredibleResidual = 0.03;

/// Whether more than a sixth of the spots with a reference are lost. RT-safe.
bool too_many_lost(const Reconstruction& found) OVWS_NONBLOCKING;

/// The opposite for a frame, whoever measured its modes: whether at least five sixths of the spots
/// with a finite position in `reference_px` are found. Outliers count as lost. RT-safe.
bool enough_found(std::span<const SpotFix> spots,
                  std::span<const Vec2> reference_px) OVWS_NONBLOCKING;
bool enough_found(const FrameRecord& record) OVWS_NONBLOCKING;

/// Goodness-of-fit test: whether the reconstructed modes explain the spot positions. At most a
/// sixth of the spots with a reference may be lost. The RMS fit residual must be at most 0.25
/// lambda/d. The limit is 0.045 lambda/d if a spot is lost or has a quality below 0.65, because
/// that spot may be a fragment of a split spot. The limit is increased in quadrature by 1.25 px
/// RMS(noise / level), twice the position noise of the least exact tracker. RT-safe.
///
/// Measured with every tracker, 5 and 7 subapertures across, SNR 2 to 22, 2 waves of astigmatism
/// and of defocus, 0.3 and 0.5 wave RMS of j = 3 to 18; residuals in lambda/d:
/// - Correctly found spots: up to 0.055, from interference of neighbours. If a spot has low
///   quality, up to 0.034 (plain centroid at 7 across: 0.052, with modes wrong by 0.1 wave).
/// - Fragments of split spots: 0.01 to 0.15. A sixth (5 across) to a half (7 across) of the frames
///   with fragments is refused; in the other frames the modes absorb the error.
/// - Higher modes that are not reconstructed: 0.07 for Kolmogorov turbulence of D/r0 = 2, where all
///   spots are whole, and 0.22 for D/r0 = 8, where some spots are split.
/// - Many lost spots: with 13 of 19 found, a wrong wavefront fits them to 0.006, and the modes err
///   by 0.2 wave. With charge 0 this affects one in seven frames with more than a sixth lost, after
///   sudden changes of 0.3 to 1.2 wave RMS. For the errors with fewer lost spots see
///   daemon/guide/accuracy.md.
bool is_explained(const Reconstruction& found, std::span<const SpotFix> spots,
                  double lambda_d_px) OVWS_NONBLOCKING;

/// Whether the spots of two sources in one image are at least 2 lambda/d apart: the circles about
/// the means of their spots that contain these. Nearer ones disturb each other: on the twin, spots
/// at 0.9 lambda/d gave modes that were wrong by 0.01 wave, at 0.5 by 0.04. True if more than half
/// of the spots of one source are lost. RT-safe.
bool are_apart(std::span<const SpotFix> one, std::span<const SpotFix> other,
               double lambda_d_px) OVWS_NONBLOCKING;
/// The same of the measurements of two sources in one frame.
bool are_apart(const FrameRecord& one, const FrameRecord& other) OVWS_NONBLOCKING;

/// The verdict on a measured frame, whose other members are set. `too_close`: its spots are too
/// close to those of another source. RT-safe.
Verdict verdict_of(const FrameRecord& record, bool too_close = false) OVWS_NONBLOCKING;

/// Returns the reconstruction summary of a frame whose modes were measured by templates. RT-safe.
Reconstruction reconstruction_of(const FittedFrame& found, std::span<const int> modes_j,
                                 std::span<const float> coefficients) OVWS_NONBLOCKING;

}  // namespace ovws
