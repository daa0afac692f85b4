#include "daemon/ovwsd/sensor/beam_watch.hpp"

#include <spdlog/fmt/fmt.h>

#include "core/pipeline/frame_rules.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/sensor/validity_watch.hpp"

namespace ovws {

BeamWatch::BeamWatch(const std::vector<BeamConfig>& beams, FrameTaps& frames)
    : all_(beams.begin(), beams.end()),
      tap_(frames, FrameTap::Needs::numbers, FrameTap::kEndless, [this](const FrameRecord& main) {
        on_frame(main);
        return true;
      }) {}

/// The source whose spots are too close to those of source `k`.
int BeamWatch::too_close_to(const FrameRecord& main, std::size_t k) {
  const auto beams = main.beams();
  if (!are_apart(main, *beams[k])) return kMain;
  for (std::size_t other = 0; other < beams.size(); ++other) {
    if (other != k && !are_apart(*beams[other], *beams[k])) return int(other);
  }
  return kNone;
}

void BeamWatch::on_frame(const FrameRecord& main) {
  if (!main.settled) return;
  for (std::size_t k = 0; k < main.beams().size(); ++k) {
    const FrameRecord& record = *main.beams()[k];
    if (!record.plan->referenced()) continue;
    One& one = all_[k];
    const std::int64_t now_ns = monotonic_ns(), since_ns = one.written.since_ns;
    one.written = {.since_ns = record.valid    ? 0
                               : since_ns == 0 ? now_ns
                                               : since_ns,
                   .t_ns = now_ns,
                   .tracked = record.tracked,
                   .spots = record.spot_count,
                   .explained = record.explained,
                   .enough_found = enough_found(record),
                   .too_close_to = record.valid ? kNone : too_close_to(main, k)};
    one.newest.write(one.written);
  }
}

std::optional<std::string> BeamWatch::why_invalid(std::size_t k, std::int64_t now_ns) const {
  return reason_of(all_[k].newest.read(), now_ns);
}

std::optional<std::string> BeamWatch::reason_of(const Newest& newest, std::int64_t now_ns) const {
  if (newest.since_ns == 0 || now_ns - newest.t_ns > kMaxFrameAgeNs) return std::nullopt;
  return fmt::format("{} of {} spots are found{}", newest.tracked, newest.spots, lack_of(newest));
}

std::string BeamWatch::lack_of(const Newest& newest) const {
  const int other = newest.too_close_to;
  if (other != kNone) {
    return ", but too close to those of " +
           (other == kMain ? "the main source" : "the source " + all_[std::size_t(other)].name) +
           ": tilt the sources apart";
  }
  if (newest.tracked == 0) return ": check the light of this source";
  return newest.enough_found && !newest.explained ? ", but no wavefront explains their positions"
                                                  : "";
}

void BeamWatch::announce(Events& events, std::int64_t now_ns) {
  for (One& one : all_) {
    const Newest newest = one.newest.read();
    const std::int64_t since_ns = newest.since_ns;
    const auto why = reason_of(newest, now_ns);
    if (why && one.announced_ns == 0 && now_ns - since_ns >= kAnnounceNs) {
      one.announced_ns = since_ns;
      events.emit("spots", Severity::warning,
                  fmt::format("of the source {}, no frame has been valid for {:.1f} s: {}",
                              one.name, 1e-9 * double(now_ns - since_ns), *why),
                  {{"valid", false}, {"beam", one.name}, {"tracked", newest.tracked}});
    } else if (one.announced_ns != 0 && since_ns == 0) {
      events.emit("spots", Severity::info,
                  fmt::format("of the source {}, frames are valid again, after {:.1f} s", one.name,
                              1e-9 * double(now_ns - one.announced_ns)),
                  {{"valid", true}, {"beam", one.name}});
      one.announced_ns = 0;
    }
  }
}

}  // namespace ovws
