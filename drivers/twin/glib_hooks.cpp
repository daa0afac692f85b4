#include "drivers/twin/glib_hooks.hpp"

#include <dlfcn.h>
#include <gio/gio.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <thread>

#include "core/port/clock.hpp"

namespace ovws::twin {
namespace {

thread_local std::int64_t poll_end_ns = 0;  // 0: none
std::atomic<std::int64_t> utc_offset_ns{utc_ns() - monotonic_ns()};
std::atomic<const Faults*> active_faults{nullptr};

/// Whether a packet is a GVCP write acknowledge: status, command, length and id of 16 bits each,
/// then 4 bytes of data. Packets of image data are longer.
bool is_write_ack(const gchar* packet, gsize size) {
  constexpr gsize kSize = 12;
  constexpr gchar kRegister = char(0x83), kMemory = char(0x87);
  return size == kSize && packet[2] == 0 && (packet[3] == kRegister || packet[3] == kMemory);
}

}  // namespace

std::int64_t twin_ns() {
  return monotonic_ns() + utc_offset_ns;
}

bool follow_utc() {
  constexpr std::int64_t kExactNs = 50'000, kStepNs = 1'000'000;
  const std::int64_t before_ns = monotonic_ns(), now_ns = utc_ns(), after_ns = monotonic_ns();
  if (after_ns - before_ns > kExactNs) return false;  // the thread was interrupted
  const std::int64_t last_ns = utc_offset_ns.exchange(now_ns - before_ns);
  return now_ns - before_ns < last_ns - kStepNs;
}

void end_polls_at(std::int64_t t_ns) {
  poll_end_ns = t_ns;
}

void delay_registers(const Faults* faults) {
  active_faults = faults;
}

}  // namespace ovws::twin

/// Aravis stamps frames by this clock, microseconds, and sends one at each multiple of the period.
extern "C" gint64 g_get_real_time() {
  return ovws::twin::twin_ns() / 1000;
}

/// Aravis waits by it for control packets and for the time of the next frame.
extern "C" gint g_poll(GPollFD* fds, guint count, gint timeout_ms) {
  using namespace ovws::twin;
  using Poll = decltype(&g_poll);
  static const Poll poll_of_glib = reinterpret_cast<Poll>(dlsym(RTLD_NEXT, "g_poll"));
  if (poll_end_ns == 0) return poll_of_glib(fds, count, timeout_ms);
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t wait_ns = std::max<std::int64_t>(0, poll_end_ns - twin_ns());
  const timespec wait{wait_ns / kSecond, wait_ns % kSecond};
  const int ready = ppoll(reinterpret_cast<pollfd*>(fds), count, &wait, nullptr);
  if (ready == 0) poll_end_ns = 0;
  return ready;
}

/// Aravis sends all packets by it.
extern "C" gssize g_socket_send_to(GSocket* socket, GSocketAddress* address, const gchar* buffer,
                                   gsize size, GCancellable* cancellable, GError** error) {
  using namespace ovws::twin;
  using Send = decltype(&g_socket_send_to);
  static const Send send = reinterpret_cast<Send>(dlsym(RTLD_NEXT, "g_socket_send_to"));
  const Faults* const faults = active_faults;
  if (faults != nullptr && is_write_ack(buffer, size)) {
    const Fault fault = faults->active();
    if (fault.kind == FaultKind::slow_registers) {
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(fault.delay_ms));
    }
  }
  return send(socket, address, buffer, size, cancellable, error);
}
