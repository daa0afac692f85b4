#include "core/optics/settle_time.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/median.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMinFrames = 8;
constexpr double kNoiseSigmas = 4.0;
constexpr double kRelativeTolerance = 0.01;  // tolerance relative to the intensity change
constexpr double kMinChange = 10.0;          // a change below 10 times the noise is not significant
constexpr double kOutlierSigmas = 3.0;       // limit for outliers, standard deviations

/// Whether the light leaves the level `before` too early. The last frame before the change may be
/// of the change, if the camera stamps late.
bool moves_before(std::span<const StepFrame> frames, double before, double tolerance) {
  for (std::size_t k = 0; k + 1 < frames.size() && frames[k + 1].begin_ms < 0.0; ++k) {
    if (std::abs(frames[k].light - before) > tolerance) return true;
  }
  return false;
}

}  // namespace

Result<StepTime> step_time(std::span<const StepFrame> frames, double before) {
  std::vector<StepFrame> after;
  for (const StepFrame& frame : frames) {
    if (frame.begin_ms >= 0.0) after.push_back(frame);
  }
  if (after.size() < kMinFrames) {
    return fail(Errc::refused, "watch_ms",
                "only " + std::to_string(after.size()) +
                    " frames were received: raise the frame rate, or raise watch_ms");
  }
  const std::span<const StepFrame> last(after.end() - std::ptrdiff_t(after.size() / 4),
                                        after.end());
  double mean = 0.0, square = 0.0;
  for (const StepFrame& frame : last) mean += frame.light / double(last.size());
  for (const StepFrame& frame : last) square += std::pow(frame.light - mean, 2);
  const double noise = std::sqrt(square / double(last.size()));
  const double change = std::abs(mean - before);
  if (!(change > kMinChange * noise)) {
    return fail(
        Errc::refused, "",
        "the camera sees no significant change when the hologram changes: run registration.run, "
        "raise the exposure, and check that nothing moves on the bench; if the SLM may be slower "
        "than watch_ms, raise watch_ms");
  }
  const double tolerance = kNoiseSigmas * noise + kRelativeTolerance * change;
  if (moves_before(frames, before, tolerance)) {
    return fail(Errc::refused, "watch_ms",
                "the hologram before had not settled when the next one came: raise watch_ms");
  }
  std::size_t first = after.size();
  while (first > 0 && std::abs(after[first - 1].light - mean) <= tolerance) --first;
  if (2 * first > after.size()) {
    return fail(Errc::refused, "watch_ms",
                "the hologram has not settled within the first half of the frames: raise watch_ms");
  }
  return StepTime{first > 0 ? after[first - 1].begin_ms : 0.0, after[first].begin_ms};
}

SettleTime settle_time(std::span<const StepTime> steps) {
  std::vector<double> until, width, off;
  SettleTime time;
  for (const StepTime& step : steps) {
    until.push_back(step.until_ms);
    width.push_back(step.until_ms - step.after_ms);
    time.worst_ms = std::max(time.worst_ms, step.until_ms);
  }
  time.p50_ms = median(until);
  for (const double one : until) off.push_back(std::abs(one - time.p50_ms));
  time.mad_ms = median(off);
  time.resolution_ms = median(width);
  const double limit_ms =
      time.p50_ms +
      std::max(time.resolution_ms, kOutlierSigmas * kSigmaPerMedianDeviation * time.mad_ms);
  for (const StepTime& step : steps) {
    if (step.until_ms > limit_ms) {
      ++time.outliers;
      continue;
    }
    time.max_ms = std::max(time.max_ms, step.until_ms);
    time.least_ms = std::max(time.least_ms, step.after_ms);
  }
  time.margin_ms = std::max(2.0, 0.2 * time.max_ms);
  time.proposed_ms = std::ceil(time.max_ms + time.margin_ms);
  return time;
}

}  // namespace ovws
