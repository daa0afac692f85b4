#include "daemon/ovwsd/sensor/search_policy.hpp"

#include <algorithm>

namespace ovws {

bool SearchPolicy::is_due(Doubt doubt, bool changed, std::int64_t now_ns) const {
  if (doubt == Doubt::none) return false;
  if (tries_ == 0) return true;
  if (doubt == Doubt::partial && now_ns < ended_ns_ + kCalmPauseNs) return false;
  return changed || now_ns >= next_ns_;
}

void SearchPolicy::begin(bool changed) {
  if (!changed) return;
  tries_ = 0;
  pause_ns_ = kFirstPauseNs;
}

void SearchPolicy::end(std::int64_t now_ns) {
  ++tries_;
  ended_ns_ = now_ns;
  next_ns_ = now_ns + pause_ns_;
  pause_ns_ = std::min(2 * pause_ns_, kMaxPauseNs);
}

}  // namespace ovws
