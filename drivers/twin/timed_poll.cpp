#include "drivers/twin/timed_poll.hpp"

#include <dlfcn.h>
#include <glib.h>
#include <poll.h>

#include <algorithm>
#include <ctime>

#include "core/port/clock.hpp"

namespace ovws::twin {
namespace {

thread_local std::int64_t poll_end_ns = 0;  // 0: none

}  // namespace

void end_polls_at(std::int64_t utc_ns) {
  poll_end_ns = utc_ns;
}

}  // namespace ovws::twin

/// Interposes GLib's g_poll, with which Aravis waits for control packets and for the next frame.
extern "C" gint g_poll(GPollFD* fds, guint count, gint timeout_ms) {
  using namespace ovws::twin;
  using Poll = decltype(&g_poll);
  static const Poll poll_of_glib = reinterpret_cast<Poll>(dlsym(RTLD_NEXT, "g_poll"));
  if (poll_end_ns == 0) return poll_of_glib(fds, count, timeout_ms);
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t wait_ns = std::max<std::int64_t>(0, poll_end_ns - ovws::utc_ns());
  const timespec wait{wait_ns / kSecond, wait_ns % kSecond};
  const int ready = ppoll(reinterpret_cast<pollfd*>(fds), count, &wait, nullptr);
  if (ready == 0) poll_end_ns = 0;
  return ready;
}
