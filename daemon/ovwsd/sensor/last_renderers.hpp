/// Cache of hologram renderers: making one takes some 15 ms per megapixel.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>

#include "core/optics/hologram.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// The last renderers that were asked for. Prepare thread.
class LastRenderers {
 public:
  /// As renew_renderer, but takes the renderer of an equal sensor and the same SLM if it is here.
  Result<void> renew(SensorState& state) {
    const auto found = std::find_if(last_.begin(), last_.end(), [&](const Entry& one) {
      return one.slm == state.slm && one.sensor == state.sensor;
    });
    if (found != last_.end()) {
      state.renderer = found->renderer;
      return {};
    }
    if (auto made = renew_renderer(state); !made) return made;
    last_.push_back({state.slm, state.sensor, state.renderer});
    if (last_.size() > kMax) last_.pop_front();
    return {};
  }

 private:
  static constexpr std::size_t kMax = 8;  ///< some MiB each
  struct Entry {
    std::shared_ptr<const ActiveSlm> slm;
    SensorConfig sensor;
    std::shared_ptr<const HologramRenderer> renderer;
  };
  std::deque<Entry> last_;
};

}  // namespace ovws
