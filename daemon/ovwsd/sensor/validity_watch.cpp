#include "daemon/ovwsd/sensor/validity_watch.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "core/pipeline/frame_rules.hpp"
#include "daemon/ovwsd/sensor/branch_check.hpp"
#include "daemon/shared/verdict_sentence.hpp"
#include "proto/dark_image.hpp"
#include "proto/limits.hpp"

namespace ovws {
namespace {

/// Without a settled frame for so long, nothing is known about the light.
constexpr std::int64_t kMaxFrameAgeNs = 1'500'000'000;
/// Frames must have been invalid for so long before an event says so.
constexpr std::int64_t kAnnounceNs = 500'000'000;
constexpr int kManyCycles = 3;  // of a sequence without a frame whose pattern is certain

/// The measurement of a source in a frame.
const FrameRecord& record_of(const FrameRecord& main, std::size_t source) {
  return source == 0 ? main : *main.beams()[source - 1];
}

std::string reason_of(const Lack& lack) {
  std::string details = lack.other != nullptr ? *lack.other : "";
  if (lack.verdict == Verdict::branch_points) {
    details = branch_point_text(lack.branch_points, lack.branch_point);
  }
  return sentence_of(lack.verdict, lack.tracked, lack.spots, details);
}

std::string search_text(const SearchProgress& search, std::int64_t now_ns) {
  if (search.running || search.searches == 0) return "the image's wavefront is being searched";
  const double wait_s = 1e-9 * double(std::max<std::int64_t>(search.next_ns - now_ns, 0));
  return fmt::format(
      "the image's wavefront was searched {}; again in {:.1f} s, or at once when the image changes",
      search.searches == 1 ? "once" : fmt::format("{} times", search.searches), wait_s);
}

/// What to do about an image that is too dark, or in which too much light has lost spots; else
/// empty.
std::string light_text(const Lack& lack, std::optional<double> brightest) {
  if (brightest && is_dark(*brightest)) return dark_text(*brightest);
  if (lack.enough_found || !(lack.saturated > limits::kMaxSaturatedSpots)) return "";
  return fmt::format(
      "too bright, {:.0f} % of the spots are saturated: lower the exposure or the gain",
      100.0 * lack.saturated);
}

/// What to do, whatever the light; empty: that depends on the search.
std::string action_of(const Lack& lack) {
  switch (lack.verdict) {
    case Verdict::no_pattern:
      return "check that each pattern triggers the camera, that dmd.slots and dmd.bit_order are "
             "the DMD's, the output's refresh rate, that the exposure is shorter than a pattern, "
             "that the camera sends timestamps, and the light";
    case Verdict::too_close:
      return "tilt the light sources apart";
    case Verdict::undetermined:
      if (lack.searched) return "";
      return "set a smaller tracking.mode_count (sensor.set), or light the lost spots";
    default:
      return "";
  }
}

}  // namespace

std::string in_words(const StatusMessage::SensorPart::Invalid& why) {
  return why.reason + (why.action.empty() ? "" : "; ") + why.action;
}

ValidityWatch::ValidityWatch(const std::vector<BeamConfig>& beams,
                             const ImageBrightness& brightness)
    : brightness_(brightness) {
  sources_.emplace_back();
  for (const BeamConfig& beam : beams) sources_.emplace_back(beam);
}

void ValidityWatch::on_frame(const FrameRecord& main, bool searched, std::int64_t now_ns) {
  if (!main.plan->patterns.empty()) {  // of a sequence, without a certain pattern
    // Not still: the hologram is changing, or there is no display.
    uncertain_ += main.still ? 1 : 0;
    const bool many = uncertain_ >= kManyCycles * main.plan->cycle.slots;
    if (!main.still || !many || !main.plan->referenced()) return;
    return note(0, {.verdict = Verdict::no_pattern, .spots = main.spot_count}, now_ns);
  }
  uncertain_ = 0;
  if (!main.settled) return;
  for (std::size_t source = 0; source <= main.beams().size(); ++source) {
    const FrameRecord& record = record_of(main, source);
    if (!record.plan->referenced()) continue;
    const bool too_close = record.verdict == Verdict::too_close;
    note(source,
         {.verdict = record.verdict,
          .tracked = record.tracked,
          .spots = record.spot_count,
          .searched = searched && source == 0,
          .enough_found = enough_found(record),
          .saturated = double(record.saturated_fraction),
          .branch_points = record.branch_points.count,
          .branch_point = record.branch_points.points.front(),
          .other = too_close ? too_close_to(main, source) : nullptr},
         now_ns);
  }
}

/// Label of a source whose spots are too close to those of `source`; null: there is none.
const std::string* ValidityWatch::too_close_to(const FrameRecord& main, std::size_t source) const {
  for (std::size_t other = 0; other <= main.beams().size(); ++other) {
    const bool near =
        other != source && !are_apart(record_of(main, other), record_of(main, source));
    if (near) return &sources_[other].label;
  }
  return nullptr;
}

void ValidityWatch::note(std::size_t source, Lack newest, std::int64_t now_ns) {
  SeqLock<Lack>& of = sources_[source].newest;
  const std::int64_t before_ns = of.read().since_ns, since_ns = before_ns != 0 ? before_ns : now_ns;
  newest.since_ns = newest.verdict == Verdict::valid ? 0 : since_ns;
  newest.t_ns = now_ns;
  of.write(newest);
}

std::optional<Lack> ValidityWatch::lack(std::size_t source, std::int64_t now_ns) const {
  const Lack newest = sources_[source].newest.read();
  if (newest.since_ns == 0 || now_ns - newest.t_ns > kMaxFrameAgeNs) return std::nullopt;
  return newest;
}

std::optional<StatusMessage::SensorPart::Invalid> ValidityWatch::why_invalid(
    std::size_t source, std::int64_t now_ns, std::int64_t utc_ns) const {
  const auto now = lack(source, now_ns);
  if (!now) return std::nullopt;
  const bool is_main = source == 0;
  const SearchProgress search = is_main ? progress_.get() : SearchProgress{};
  StatusMessage::SensorPart::Invalid invalid;
  invalid.t_since_ns = utc_ns - (now_ns - now->since_ns);
  invalid.reason = reason_of(*now);
  invalid.action = action_of(*now);
  if (!invalid.action.empty()) return invalid;
  const std::string light =
      light_text(*now, is_main ? brightness_.newest(now_ns) : std::optional<double>());
  const bool waits = now->verdict == Verdict::unconfirmed;
  invalid.action = !light.empty() ? light
                   : now->verdict == Verdict::branch_points
                       ? "no smooth wavefront exists: remove what splits the light, or wait"
                   : !is_main       ? (now->tracked == 0 ? "check the light of this source" : "")
                   : !now->searched ? "use the tracker fit: it also finds strong aberrations"
                   : waits          ? "wait: templates of this wavefront are being rendered"
                                    : search_text(search, now_ns);
  invalid.searches = search.searches;
  if (now->searched && !search.running && !waits) {
    invalid.t_next_search_ns = utc_ns + std::max<std::int64_t>(search.next_ns - now_ns, 0);
  }
  return invalid;
}

void ValidityWatch::search_begins() {
  progress_.change([](SearchProgress& now) { now.running = true; });
}

void ValidityWatch::search_failed(std::int64_t next_ns) {
  progress_.change([&](SearchProgress& now) { now = {false, now.searches + 1, next_ns}; });
}

void ValidityWatch::announce(Events& events, std::int64_t now_ns) {
  if (is_valid(0)) progress_.change([](SearchProgress& progress) { progress.searches = 0; });
  for (std::size_t source = 0; source < sources_.size(); ++source) {
    announce(source, events, now_ns);
  }
}

void ValidityWatch::announce(std::size_t source, Events& events, std::int64_t now_ns) {
  Source& of = sources_[source];
  const std::string whose = source == 0 ? "" : "of " + of.label + ", ";
  const auto told = [&](Severity severity, const std::string& text, nlohmann::json data) {
    if (source != 0) data["beam"] = of.name;
    events.emit("spots", severity, whose + text, std::move(data));
  };
  const auto why = why_invalid(source, now_ns, 0);
  const auto now = lack(source, now_ns);
  if (why && now && of.announced_ns == 0 && now_ns - now->since_ns >= kAnnounceNs) {
    of.announced_ns = now->since_ns;
    nlohmann::json data{{"valid", false}, {"tracked", now->tracked}, {"searches", why->searches}};
    if (now->branch_points > 0) {
      data["branch_point"] = {{"x", now->branch_point.at.x},
                              {"y", now->branch_point.at.y},
                              {"charge", now->branch_point.charge}};
    }
    told(Severity::warning,
         fmt::format("no frame has been valid for {:.1f} s: {}",
                     1e-9 * double(now_ns - now->since_ns), in_words(*why)),
         std::move(data));
  }
  if (of.announced_ns == 0 || !is_valid(source)) return;
  told(Severity::info,
       fmt::format("frames are valid again, after {:.1f} s",
                   1e-9 * double(now_ns - of.announced_ns)),
       {{"valid", true}});
  of.announced_ns = 0;
}

}  // namespace ovws
