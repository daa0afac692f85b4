#include "drivers/sdl/refresh_clock.hpp"

#include <poll.h>
#include <xcb/present.h>
#include <xcb/xcb.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws::sdl {
namespace {

constexpr std::int64_t kPatienceNs = 100'000'000;
constexpr std::int64_t kSmoothing = 16;
constexpr std::int64_t kFirstPatienceNs = 1'500'000'000;  // an output that wakes up

struct Disconnect {
  void operator()(xcb_connection_t* connection) const { xcb_disconnect(connection); }
};
using XcbConnection = std::unique_ptr<xcb_connection_t, Disconnect>;

struct Free {
  void operator()(void* memory) const { std::free(memory); }
};
template <class T>
using Answer = std::unique_ptr<T, Free>;

/// Whether the server has a PRESENT extension that can tell refreshes.
bool has_present(xcb_connection_t* connection) {
  const auto* const extension = xcb_get_extension_data(connection, &xcb_present_id);
  if (extension == nullptr || extension->present == 0) return false;
  const Answer<xcb_present_query_version_reply_t> version(xcb_present_query_version_reply(
      connection, xcb_present_query_version(connection, 1, 0), nullptr));
  return version != nullptr;
}

}  // namespace

struct RefreshClock::Impl {
  XcbConnection connection;
  std::uint32_t window = 0;
  std::int64_t period_ns = 0;
  xcb_special_event_t* events = nullptr;
  std::uint32_t asked = 0, answered = 0;  ///< numbers of requests
  std::int64_t refresh_ns = 0;            ///< time of the last one, CLOCK_MONOTONIC

  void ask();
  void read_answers();
  void follow(std::int64_t reported_ns);
  bool wait_for_answer(std::int64_t until_ns);
};

RefreshClock::RefreshClock(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

RefreshClock::~RefreshClock() {
  xcb_unregister_for_special_event(impl_->connection.get(), impl_->events);
}

std::unique_ptr<RefreshClock> RefreshClock::open(std::uint32_t x_window, double refresh_hz) {
  auto impl = std::make_unique<Impl>();
  impl->connection.reset(xcb_connect(nullptr, nullptr));
  xcb_connection_t* const connection = impl->connection.get();
  if (xcb_connection_has_error(connection) != 0 || !has_present(connection)) return nullptr;
  impl->window = x_window;
  impl->period_ns = std::llround(1e9 / refresh_hz);
  const std::uint32_t id = xcb_generate_id(connection);
  impl->events = xcb_register_for_special_xge(connection, &xcb_present_id, id, nullptr);
  const Answer<xcb_generic_error_t> refused(xcb_request_check(
      connection, xcb_present_select_input_checked(connection, id, x_window,
                                                   XCB_PRESENT_EVENT_MASK_COMPLETE_NOTIFY)));
  std::unique_ptr<RefreshClock> clock(new RefreshClock(std::move(impl)));
  if (refused) return nullptr;
  clock->impl_->ask();
  if (!clock->impl_->wait_for_answer(monotonic_ns() + kFirstPatienceNs)) return nullptr;
  return clock;
}

std::int64_t RefreshClock::wait() {
  impl_->read_answers();
  impl_->ask();
  const std::int64_t now_ns = monotonic_ns();
  if (now_ns > impl_->refresh_ns + kPatienceNs) {
    return impl_->wait_for_answer(now_ns + kPatienceNs) ? impl_->refresh_ns : 0;
  }
  // The last reported refresh may be still to come.
  std::int64_t left_ns = (impl_->refresh_ns - now_ns) % impl_->period_ns;
  if (left_ns <= 0) left_ns += impl_->period_ns;
  std::this_thread::sleep_for(std::chrono::nanoseconds(left_ns));
  return now_ns + left_ns;
}

/// Asks for the next refresh, if no answer is awaited.
void RefreshClock::Impl::ask() {
  if (asked != answered) return;
  // A multiple of one refresh, and later than now: the next one.
  xcb_present_notify_msc(connection.get(), window, ++asked, 0, 1, 0);
  xcb_flush(connection.get());
}

void RefreshClock::Impl::read_answers() {
  while (const Answer<xcb_generic_event_t> event{
      xcb_poll_for_special_event(connection.get(), events)}) {
    const auto* const done =
        reinterpret_cast<const xcb_present_complete_notify_event_t*>(event.get());
    const bool tells_refresh = done->event_type == XCB_PRESENT_COMPLETE_NOTIFY &&
                               done->kind == XCB_PRESENT_COMPLETE_KIND_NOTIFY_MSC;
    if (!tells_refresh || done->serial != asked) continue;
    answered = asked;
    follow(std::int64_t(done->ust) * 1000);
  }
}

/// Takes a reported refresh. Timers of servers without hardware jitter by some milliseconds, so its
/// deviation from what the earlier ones say counts with a small part only.
void RefreshClock::Impl::follow(std::int64_t reported_ns) {
  const std::int64_t periods = (reported_ns - refresh_ns + period_ns / 2) / period_ns;
  const std::int64_t expected_ns = refresh_ns + periods * period_ns;
  const std::int64_t error_ns = reported_ns - expected_ns;
  const bool goes_on = std::abs(error_ns) < period_ns / 4 && periods * period_ns < kPatienceNs;
  refresh_ns = goes_on ? expected_ns + error_ns / kSmoothing : reported_ns;
}

bool RefreshClock::Impl::wait_for_answer(std::int64_t until_ns) {
  for (;;) {
    read_answers();
    if (answered == asked) return true;
    const std::int64_t left_ns = until_ns - monotonic_ns();
    if (left_ns <= 0 || xcb_connection_has_error(connection.get()) != 0) return false;
    pollfd readable{xcb_get_file_descriptor(connection.get()), POLLIN, 0};
    poll(&readable, 1, int(left_ns / 1'000'000) + 1);
  }
}

}  // namespace ovws::sdl
