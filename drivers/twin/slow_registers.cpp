#include "drivers/twin/slow_registers.hpp"

#include <dlfcn.h>
#include <gio/gio.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace ovws::twin {
namespace {

std::atomic<const Faults*> active_faults{nullptr};

/// Whether a packet is a GVCP write acknowledge: status, command, length and id of 16 bits each,
/// then 4 bytes of data. Packets of image data are longer.
bool is_write_ack(const gchar* packet, gsize size) {
  constexpr gsize kSize = 12;
  constexpr gchar kRegister = char(0x83), kMemory = char(0x87);
  return size == kSize && packet[2] == 0 && (packet[3] == kRegister || packet[3] == kMemory);
}

}  // namespace

SlowRegisters::SlowRegisters(const Faults& faults) {
  active_faults = &faults;
}

SlowRegisters::~SlowRegisters() {
  active_faults = nullptr;
}

}  // namespace ovws::twin

/// Interposes GLib's g_socket_send_to, with which Aravis sends all packets. Calls GLib's function
/// after the delay.
extern "C" gssize g_socket_send_to(GSocket* socket, GSocketAddress* address, const gchar* buffer,
                                   gsize size, GCancellable* cancellable, GError** error) {
  using Send = decltype(&g_socket_send_to);
  static const Send send = reinterpret_cast<Send>(dlsym(RTLD_NEXT, "g_socket_send_to"));
  const ovws::twin::Faults* const faults = ovws::twin::active_faults;
  if (faults != nullptr && ovws::twin::is_write_ack(buffer, size)) {
    const ovws::twin::Fault fault = faults->active();
    if (fault.kind == ovws::twin::FaultKind::slow_registers) {
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(fault.delay_ms));
    }
  }
  return send(socket, address, buffer, size, cancellable, error);
}
