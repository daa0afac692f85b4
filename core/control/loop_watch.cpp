#include "core/control/loop_watch.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {

LoopWatch::LoopWatch(const LoopSettings& settings, std::int64_t now_ns)
    : patience_s_(settings.patience_s),
      growth_(settings.growth),
      floor_waves_(settings.floor_waves),
      t_last_ns_(now_ns) {}

/// Whether `condition` has held without interruption for `patience_s`.
bool LoopWatch::lasts(bool condition, std::optional<std::int64_t>& since_ns,
                      std::int64_t now_ns) const {
  if (!condition) {
    since_ns.reset();
    return false;
  }
  if (!since_ns) since_ns = now_ns;
  return 1e-9 * double(now_ns - *since_ns) >= patience_s_;
}

void LoopWatch::follow_level(double residual_rms_waves, std::int64_t now_ns) {
  constexpr double kSlowUp = 10.0;
  if (!level_waves_) {
    level_waves_ = residual_rms_waves;
    return;
  }
  const double time_s = (residual_rms_waves > *level_waves_ ? kSlowUp : 1.0) * patience_s_;
  const double part = 1.0 - std::exp(-1e-9 * double(now_ns - t_last_ns_) / time_s);
  *level_waves_ += part * (residual_rms_waves - *level_waves_);
}

LoopEnd LoopWatch::step(double residual_rms_waves, bool at_limit, std::int64_t now_ns) {
  follow_level(residual_rms_waves, now_ns);
  t_last_ns_ = now_ns;
  const double grown = std::max(floor_waves_, growth_ * *level_waves_);
  if (lasts(at_limit, at_limit_since_ns_, now_ns)) return LoopEnd::at_limit;
  if (lasts(residual_rms_waves > grown, growing_since_ns_, now_ns)) return LoopEnd::growing;
  return LoopEnd::none;
}

LoopEnd LoopWatch::wait(std::int64_t now_ns, std::int64_t found_ns) const {
  const double waited_s = 1e-9 * double(now_ns - t_last_ns_);
  const double unfound_s = std::min(waited_s, 1e-9 * double(now_ns - found_ns));
  const bool ends = unfound_s >= patience_s_ || waited_s >= kMaxPatience * patience_s_;
  return ends ? LoopEnd::too_few_spots : LoopEnd::none;
}

}  // namespace ovws
