#include "daemon/ovwsd/sensor/validity_watch.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace ovws {
namespace {

constexpr std::int64_t kMaxFrameAgeNs = 1'500'000'000;

std::string action_of(const SearchProgress& search, std::int64_t now_ns) {
  if (search.running || search.searches == 0) return "the whole image is being searched for spots";
  const double wait_s = 1e-9 * double(std::max<std::int64_t>(search.next_ns - now_ns, 0));
  return fmt::format(
      "the whole image was searched {} for spots; again in {:.1f} s, or at once when it changes",
      search.searches == 1 ? "once" : fmt::format("{} times", search.searches), wait_s);
}

}  // namespace

void ValidityWatch::on_frame(bool valid, const Lack& lack, std::int64_t now_ns) {
  tracked_ = lack.tracked;
  spots_ = lack.spots;
  explained_ = lack.explained;
  waits_ = lack.waits;
  newest_ns_ = now_ns;
  if (valid) {
    since_ns_ = 0;
  } else if (since_ns_ == 0) {
    since_ns_ = now_ns;
  }
}

std::optional<ValidityWatch::Lack> ValidityWatch::lack(std::int64_t now_ns) const {
  const std::int64_t since_ns = since_ns_;
  if (since_ns == 0 || now_ns - newest_ns_ > kMaxFrameAgeNs) return std::nullopt;
  return Lack{since_ns, tracked_, spots_, explained_, waits_};
}

StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns) {
  StatusMessage::SensorPart::Invalid invalid;
  invalid.t_since_ns = utc_ns - (now_ns - lack.since_ns);
  invalid.reason = fmt::format("{} of {} spots are found{}", lack.tracked, lack.spots,
                               lack.waits       ? ", but templates have not confirmed them yet"
                               : lack.explained ? ""
                                                : ", but no wavefront explains their positions");
  invalid.action =
      lack.waits ? "templates of this wavefront are awaited" : action_of(search, now_ns);
  invalid.searches = search.searches;
  if (!search.running && !lack.waits)
    invalid.t_next_search_ns = utc_ns + std::max<std::int64_t>(search.next_ns - now_ns, 0);
  return invalid;
}

}  // namespace ovws
