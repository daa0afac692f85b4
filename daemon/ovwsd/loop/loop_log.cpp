#include "daemon/ovwsd/loop/loop_log.hpp"

#include <utility>

#include "core/port/clock.hpp"
#include "proto/tables/loop.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr std::size_t kFrames = 200;  // of one document

}  // namespace

void LoopLog::closed(const LoopSettings& settings, std::span<const Mode> correction,
                     const LoopModel* model) {
  t_closed_ns_ = utc_ns();
  frames_ = json::array();
  write_("loop", {{"t_closed_ns", t_closed_ns_},
                  {"settings", to_json(settings)},
                  {"correction", to_json(std::vector<Mode>(correction.begin(), correction.end()))},
                  {"model", model == nullptr ? json() : to_json(model->modes)}});
}

void LoopLog::observed(std::uint64_t frame_id, std::int64_t t_ns) {
  if (frames_.size() == kFrames) flush();
  frames_.push_back({frame_id, t_ns});
}

void LoopLog::decided(std::int64_t t_for_ns, std::uint64_t hologram_id) {
  frames_.back().push_back(t_for_ns);
  frames_.back().push_back(hologram_id);
}

void LoopLog::flush() {
  if (frames_.empty()) return;
  write_("loop_steps", {{"t_closed_ns", t_closed_ns_}, {"frames", std::move(frames_)}});
  frames_ = json::array();
}

}  // namespace ovws
