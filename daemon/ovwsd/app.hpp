/// The composition root: creates every part of the daemon, connects the parts, and runs them until
/// a stop is requested.
#pragma once

#include <atomic>
#include <memory>

#include "core/base/result.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// The whole daemon. Call all methods in the main thread, unless stated otherwise.
class App {
 public:
  /// Creates all parts and opens the sockets. Errors: the configuration makes no usable sensor, or
  /// a port or the state folder is in use. An absent camera or display is no error: the daemon
  /// waits.
  static Result<std::unique_ptr<App>> make(const LoadedConfig& loaded);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Starts the threads, shows holograms until `stop` is set, then stops all threads in order.
  /// Errors: a privilege is missing under `"realtime": "enforce"`; a thread failed without which
  /// the daemon cannot continue; data could not be written at the stop.
  Result<void> run(const std::atomic<bool>& stop);
  /// Requests a reload of the configuration file. Thread-safe and async-signal-safe, so that the
  /// SIGHUP handler may call this method while `run` lasts.
  void reload();

 private:
  struct Parts;
  explicit App(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ovws
