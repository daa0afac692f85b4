#include "core/pipeline/frame_rules.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ovws {
namespace {

constexpr double kMaxResidual = 0.25;         // RMS fit residual, lambda/d
constexpr double kMaxResidualSplit = 0.045;   // RMS fit residual, lambda/d, if a spot may be split
constexpr float kMinWholeQuality = 0.65F;     // a spot of lower quality may be a fragment
constexpr int kMinSpotsPerLost = 6;           // at most one of this many spots may be lost
constexpr double kResidualOfNoisePx = 1.25;   // residual by noise, px at RMS(noise / level) = 1
constexpr std::int64_t kLateNs = 50'000'000;  // tolerated delay: a busy host causes it at times
constexpr double kLatePeriods = 3.0;
constexpr double kLeastGap = 2.0;  // between the spots of two sources, lambda/d

std::int64_t exposure_begin(const AppliedSettings& settings, double exposure_us,
                            std::int64_t arrival_mono_ns) {
  return arrival_mono_ns - std::llround(exposure_us * 1e3) - settings.transfer_ns;
}

/// The circle about the mean of the found spots that contains them; none if more than half are
/// lost: those found may be of another source.
std::optional<Disc> disc_of(std::span<const SpotFix> spots) OVWS_NONBLOCKING {
  Vec2 sum;
  int count = 0;
  for (const SpotFix& spot : spots) {
    if (!spot.found()) continue;
    sum = sum + Vec2{spot.x, spot.y};
    ++count;
  }
  if (count == 0 || 2 * count < int(spots.size())) return std::nullopt;
  Disc disc{1.0 / count * sum, 0.0};
  for (const SpotFix& spot : spots) {
    if (spot.found()) disc.radius = std::max(disc.radius, norm(Vec2{spot.x, spot.y} - disc.centre));
  }
  return disc;
}

}  // namespace

SettingsVerdict judge_settings(const AppliedSettings& settings, std::int64_t arrival_mono_ns) {
  const double longer_us = std::max(settings.exposure_us, settings.previous_exposure_us);
  const std::int64_t earliest = exposure_begin(settings, longer_us, arrival_mono_ns);
  // Use the longer exposure: a frame with the previous, longer exposure may have begun before the
  // write. The new values apply for sure only if even its start lies after the write.
  if (settings.exposure_us > 0.0 && earliest >= settings.t_write_end_mono_ns) {
    return {true, settings.gain_db, settings.gain_raw, settings.exposure_us,
            exposure_begin(settings, settings.exposure_us, arrival_mono_ns)};
  }
  const std::int64_t previous =
      exposure_begin(settings, settings.previous_exposure_us, arrival_mono_ns);
  if (settings.previous_exposure_us > 0.0 && arrival_mono_ns <= settings.t_write_begin_mono_ns &&
      previous >= settings.t_previous_end_mono_ns) {
    return {true, settings.previous_gain_db, settings.previous_gain_raw,
            settings.previous_exposure_us, previous};
  }
  return {false, settings.gain_db, settings.gain_raw, settings.exposure_us, earliest};
}

bool is_late(const AppliedSettings& settings, std::int64_t arrival_mono_ns,
             std::int64_t undelayed_mono_ns) OVWS_NONBLOCKING {
  const double period_ns = settings.frame_rate_hz > 0.0 ? 1e9 / settings.frame_rate_hz : 0.0;
  const std::int64_t patience_ns =
      std::max<std::int64_t>(kLateNs, std::llround(kLatePeriods * period_ns));
  return arrival_mono_ns - undelayed_mono_ns > settings.transfer_ns + patience_ns;
}

HologramVerdict judge_hologram(const ShownHologram& shown, std::uint64_t plan_sensor_epoch,
                               std::int64_t exposure_begin_mono_ns, std::int64_t arrival_mono_ns) {
  const auto of = [&](const ShownHologram::One& one) {
    const bool fits = one.sensor_epoch != 0 && one.sensor_epoch == plan_sensor_epoch;
    return HologramVerdict{one.hologram_id, true, fits, one.sequence};
  };
  if (shown.healthy && exposure_begin_mono_ns >= shown.current.t_settled_mono_ns) {
    return of(shown.current);
  }
  if (shown.healthy && arrival_mono_ns <= shown.current.t_begin_mono_ns &&
      exposure_begin_mono_ns >= shown.previous.t_settled_mono_ns) {
    return of(shown.previous);
  }
  return {shown.current.hologram_id, false, false, shown.current.sequence};
}

bool too_many_lost(const Reconstruction& found) {
  return kMinSpotsPerLost * found.lost > found.used + found.lost;
}

bool enough_found(std::span<const SpotFix> spots, std::span<const Vec2> reference_px) {
  Reconstruction found;
  for (std::size_t i = 0; i < std::min(spots.size(), reference_px.size()); ++i) {
    if (!std::isfinite(reference_px[i].x) || !std::isfinite(reference_px[i].y)) continue;
    ++(spots[i].found() ? found.used : found.lost);
  }
  return !too_many_lost(found);
}

bool enough_found(const FrameRecord& record) {
  return enough_found({record.spots.data(), std::size_t(record.spot_count)},
                      record.plan->reference_px);
}

bool is_explained(const Reconstruction& found, std::span<const SpotFix> spots, double lambda_d_px) {
  if (too_many_lost(found)) return false;
  bool all_whole = found.lost == 0;
  double squares = 0.0;
  int count = 0;
  for (const SpotFix& spot : spots) {
    if (!spot.found()) continue;
    all_whole = all_whole && spot.quality >= kMinWholeQuality;
    const double noise = spot.level > 0.0F ? double(spot.noise) / double(spot.level) : 0.0;
    squares += noise * noise;
    ++count;
  }
  const double noise_px = kResidualOfNoisePx * std::sqrt(squares / std::max(count, 1));
  const double limit_px = (all_whole ? kMaxResidual : kMaxResidualSplit) * lambda_d_px;
  return found.fit_residual_px <= std::hypot(limit_px, noise_px);
}

bool are_apart(std::span<const SpotFix> one, std::span<const SpotFix> other, double lambda_d_px) {
  const auto a = disc_of(one), b = disc_of(other);
  if (!a || !b) return true;
  return norm(a->centre - b->centre) >= a->radius + b->radius + kLeastGap * lambda_d_px;
}

bool are_apart(const FrameRecord& one, const FrameRecord& other) {
  const auto spots = [](const FrameRecord& of) {
    return std::span(of.spots.data(), std::size_t(of.spot_count));
  };
  return are_apart(spots(one), spots(other), one.plan->spots.lambda_d_px);
}

Verdict verdict_of(const FrameRecord& record, bool too_close) {
  const MeasurementPlan& plan = *record.plan;
  if (record.valid) return Verdict::valid;
  if (record.late) return Verdict::late;
  if (!record.still) return Verdict::changing;
  if (!plan.patterns.empty()) return Verdict::no_pattern;
  if (!record.settled) return Verdict::other_hologram;
  if (!plan.referenced()) return Verdict::no_reference;
  if (too_close) return Verdict::too_close;
  const bool enough = enough_found(record);
  if (enough && !record.reconstruction.determined) return Verdict::undetermined;
  if (record.branch_points.count > 0) return Verdict::branch_points;
  if (record.unconfirmed) return Verdict::unconfirmed;
  return enough && !record.explained ? Verdict::unexplained : Verdict::spots_lost;
}

Reconstruction reconstruction_of(const FittedFrame& found, std::span<const int> modes_j,
                                 std::span<const float> coefficients) {
  Reconstruction summary{.determined = true,
                         .fit_residual_px = found.residual_px,
                         .used = found.used,
                         .lost = found.lost};
  double squares = 0.0;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (modes_j[k] > 2) squares += std::pow(double(coefficients[k]), 2);
  }
  summary.rms_waves = std::sqrt(squares);
  return summary;
}

}  // namespace ovws
