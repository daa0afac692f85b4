#include "core/pipeline/pattern_follower.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

constexpr int kRowStep = 4;             // rows from one that is summed to the next
constexpr double kTolerance = 0.25;     // of a frame's time, slots
constexpr double kPeriodError = 0.1;    // of PatternCycle::period_ns
constexpr std::int64_t kMaxUnseen = 4;  // cycles without a mark, then it is searched again

}  // namespace

double light_of(const ImageView& image) OVWS_NONBLOCKING {
  double sum = 0.0;
  for (int y = 0; y < image.height; y += kRowStep) {
    visit_rows(image, 0, y, image.width, 1, [&](int, int, const auto* pixels, int count) {
      std::uint32_t row = 0;  // at most 65535 pixels of 65535
      for (int x = 0; x < count; ++x) row += pixels[x];
      sum += double(row);
    });
  }
  return sum;
}

int PatternFollower::follow(const PatternCycle& cycle, std::int64_t t_ns,
                            double light) OVWS_NONBLOCKING {
  const Seen now{t_ns, light};
  seen_[std::size_t(count_++) % seen_.size()] = now;
  if (found_) return slot_of(cycle, now);
  search(cycle);
  return found_ ? 0 : kUncertain;
}

/// Whether the newest frames are a whole cycle and the next one's mark.
void PatternFollower::search(const PatternCycle& cycle) OVWS_NONBLOCKING {
  if (count_ <= cycle.slots) return;
  const auto at = [&](int k) -> const Seen& {  // k = 0 .. slots
    return seen_[std::size_t(count_ - 1 - cycle.slots + k) % seen_.size()];
  };
  const auto [first, last] = std::minmax(at(0).light, at(cycle.slots).light);
  double darkest = at(1).light, brightest = at(1).light;
  const double period = double(at(cycle.slots).t_ns - at(0).t_ns) / cycle.slots;
  if (std::abs(period - double(cycle.period_ns)) > kPeriodError * double(cycle.period_ns)) return;
  for (int k = 1; k < cycle.slots; ++k) {
    darkest = std::min(darkest, at(k).light);
    brightest = std::max(brightest, at(k).light);
    if (std::abs(double(at(k).t_ns - at(0).t_ns) - k * period) > kTolerance * period) return;
  }
  const double limit = 0.5 * (first + brightest);
  if (last >= limit || darkest < limit) return;
  found_ = true;
  limit_ = limit;
  period_ns_ = period;
  t_mark_ns_ = at(cycle.slots).t_ns;
}

int PatternFollower::slot_of(const PatternCycle& cycle, const Seen& now) OVWS_NONBLOCKING {
  const double slots = double(now.t_ns - t_mark_ns_) / period_ns_;
  const std::int64_t passed = std::llround(slots);
  const std::int64_t cycles = passed / cycle.slots;
  const int slot = int(passed % cycle.slots);
  const bool in_time = passed > 0 && std::abs(slots - double(passed)) <= kTolerance;
  if (!in_time || cycles > kMaxUnseen || (now.light < limit_) != (slot == 0)) {
    lose();
    return kUncertain;
  }
  if (slot == 0) {
    if (cycles == 1) period_ns_ = double(now.t_ns - t_mark_ns_) / cycle.slots;
    t_mark_ns_ = now.t_ns;
    return 0;
  }
  return cycles == 0 ? slot : kUncertain;
}

/// The frames so far are of no use either: something between them was not as it should be.
void PatternFollower::lose() OVWS_NONBLOCKING {
  found_ = false;
  count_ = 0;
}

}  // namespace ovws
