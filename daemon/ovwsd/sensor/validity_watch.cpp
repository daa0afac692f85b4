#include "daemon/ovwsd/sensor/validity_watch.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "daemon/ovwsd/sensor/branch_check.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"

namespace ovws {
namespace {

std::string action_of(const SearchProgress& search, std::int64_t now_ns) {
  if (search.running || search.searches == 0) return "the image's wavefront is being searched";
  const double wait_s = 1e-9 * double(std::max<std::int64_t>(search.next_ns - now_ns, 0));
  return fmt::format(
      "the image's wavefront was searched {}; again in {:.1f} s, or at once when the image changes",
      search.searches == 1 ? "once" : fmt::format("{} times", search.searches), wait_s);
}

/// What to do about an image that is too dark, or in which too much light has lost spots; else
/// empty.
std::string light_text(const ValidityWatch::Lack& lack) {
  if (lack.brightest && is_dark(*lack.brightest)) return dark_text(*lack.brightest);
  if (lack.enough_found || !(lack.saturated > limits::kMaxSaturatedSpots)) return "";
  return fmt::format(
      "too bright, {:.0f} % of the spots are saturated: lower the exposure or the gain",
      100.0 * lack.saturated);
}

/// What the branch points of the newest frame mean; empty if there are none.
std::string branch_text(const ValidityWatch::Lack& lack) {
  if (lack.branch_points == 0) return "";
  return "; the light has " + branch_point_text(lack.branch_points, lack.branch_point);
}

}  // namespace

void ValidityWatch::on_frame(bool valid, const Lack& lack, std::int64_t now_ns) {
  const std::int64_t since_ns = written_.lack.since_ns;
  written_ = {lack, now_ns};
  written_.lack.since_ns = valid ? 0 : since_ns == 0 ? now_ns : since_ns;
  newest_.write(written_);
}

std::optional<ValidityWatch::Lack> ValidityWatch::lack(std::int64_t now_ns) const {
  Newest newest = newest_.read();
  if (newest.lack.since_ns == 0 || now_ns - newest.t_ns > kMaxFrameAgeNs) return std::nullopt;
  newest.lack.brightest = brightness_.newest(now_ns);
  return newest.lack;
}

StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns) {
  StatusMessage::SensorPart::Invalid invalid;
  invalid.t_since_ns = utc_ns - (now_ns - lack.since_ns);
  if (lack.no_pattern) {
    invalid.reason = "no frame's pattern is certain";
    invalid.action =
        "check that each pattern triggers the camera, that dmd.slots and dmd.bit_order are the "
        "DMD's, the output's refresh rate, that the exposure is shorter than a pattern, that the "
        "camera sends timestamps, and the light";
    return invalid;
  }
  if (lack.too_close) {
    invalid.reason = fmt::format("{} of {} spots are found, but too close to another source's",
                                 lack.tracked, lack.spots);
    invalid.action = "tilt the light sources apart: sensor.beams of status names the other one";
    return invalid;
  }
  if (lack.undetermined && !lack.searched) {
    invalid.reason = fmt::format("{} of {} spots are found, which do not determine all modes",
                                 lack.tracked, lack.spots);
    invalid.action = "set a smaller tracking.mode_count (sensor.set), or light the lost spots";
    return invalid;
  }
  const bool has_branch_points = lack.branch_points > 0;
  const bool unexplained = lack.enough_found && !lack.explained;
  invalid.reason = fmt::format("{} of {} spots are found{}", lack.tracked, lack.spots,
                               has_branch_points ? branch_text(lack)
                               : lack.waits      ? ", but templates have not confirmed them yet"
                               : unexplained     ? ", but no wavefront explains their positions"
                                                 : "");
  const std::string light = light_text(lack);
  invalid.action = !light.empty() ? light
                   : has_branch_points
                       ? "no smooth wavefront exists: remove what splits the light, or wait"
                   : !lack.searched ? "use the tracker fit: it also finds strong aberrations"
                   : lack.waits     ? "wait: templates of this wavefront are being rendered"
                                    : action_of(search, now_ns);
  invalid.searches = search.searches;
  if (lack.searched && !search.running && !lack.waits)
    invalid.t_next_search_ns = utc_ns + std::max<std::int64_t>(search.next_ns - now_ns, 0);
  return invalid;
}

std::optional<StatusMessage::SensorPart::Invalid> ValidityWatch::why_invalid(
    std::int64_t now_ns, std::int64_t utc_ns) const {
  const auto now = lack(now_ns);
  if (!now) return std::nullopt;
  return invalid_in_words(*now, progress_.get(), now_ns, utc_ns);
}

void ValidityWatch::search_begins() {
  progress_.change([](SearchProgress& now) { now.running = true; });
}

void ValidityWatch::search_failed(std::int64_t next_ns) {
  progress_.change([&](SearchProgress& now) { now = {false, now.searches + 1, next_ns}; });
}

void ValidityWatch::announce(Events& events, std::int64_t now_ns) {
  if (is_valid()) progress_.change([](SearchProgress& progress) { progress.searches = 0; });
  const auto now = lack(now_ns);
  if (now && announced_ns_ == 0 && now_ns - now->since_ns >= kAnnounceNs) {
    announced_ns_ = now->since_ns;
    const auto why = invalid_in_words(*now, progress_.get(), now_ns, 0);
    nlohmann::json data{{"valid", false}, {"tracked", now->tracked}, {"searches", why.searches}};
    if (now->branch_points > 0) {
      data["branch_point"] = {{"x", now->branch_point.at.x},
                              {"y", now->branch_point.at.y},
                              {"charge", now->branch_point.charge}};
    }
    events.emit("spots", Severity::warning,
                fmt::format("no frame has been valid for {:.1f} s: {}; {}",
                            1e-9 * double(now_ns - now->since_ns), why.reason, why.action),
                data);
  }
  if (announced_ns_ == 0 || !is_valid()) return;
  events.emit(
      "spots", Severity::info,
      fmt::format("frames are valid again, after {:.1f} s", 1e-9 * double(now_ns - announced_ns_)),
      {{"valid", true}});
  announced_ns_ = 0;
}

}  // namespace ovws
