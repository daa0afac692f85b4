#include "daemon/ovwsd/frames/frame_tap.hpp"

#include <algorithm>
#include <exception>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {

/// The serving thread uses the list.
class FrameTaps::Line::Turn {
 public:
  explicit Turn(Line& line) : line_(line) { ++line_.turns_; }
  ~Turn() { ++line_.turns_; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  const List& taps() const { return *line_.served_.load(); }

 private:
  Line& line_;
};

void FrameTaps::Line::serve(const FrameRecord& record) {
  const Turn turn(*this);
  std::exception_ptr failure;
  for (FrameTap* const tap : turn.taps()) {
    try {
      tap->look_at(record);
    } catch (...) {  // serve the other taps first, then rethrow
      failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

bool FrameTaps::Line::is_wanted() {
  const Turn turn(*this);
  return std::ranges::any_of(turn.taps(), [](const FrameTap* tap) { return !tap->done(); });
}

void FrameTaps::Line::add(FrameTap* tap) {
  const std::lock_guard lock(mutex_);
  List next = *list_;
  next.push_back(tap);
  change(std::move(next));
}

void FrameTaps::Line::remove(FrameTap* tap) {
  const std::lock_guard lock(mutex_);
  List next = *list_;
  if (std::erase(next, tap) > 0) change(std::move(next));
}

/// Read-copy-update: a turn that begins from now on uses the new list, and one that has begun
/// before may use the old one until it ends.
void FrameTaps::Line::change(List next) {
  auto list = std::make_unique<const List>(std::move(next));
  served_ = list.get();
  const std::uint64_t turn = turns_;
  while (turn % 2 != 0 && turns_ == turn) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  list_ = std::move(list);
}

FrameTap::FrameTap(FrameTaps& taps, Needs needs, std::int64_t frames, Take take)
    : line_(taps.line_for(needs)),
      frames_(frames),
      take_(std::move(take)),
      t_last_used_ns_(monotonic_ns()) {
  line_.add(this);
}

bool FrameTap::wait_for(std::chrono::milliseconds timeout) {
  bool all = false;
  return done() || all_used_.pop(all, timeout);
}

double FrameTap::idle_s() const {
  return 1e-9 * double(monotonic_ns() - t_last_used_ns_.load());
}

void FrameTap::look_at(const FrameRecord& record) {
  if (done() || !take_(record)) return;
  t_last_used_ns_ = monotonic_ns();
  if (++used_ == frames_) (void)all_used_.try_push(true);
}

}  // namespace ovws
