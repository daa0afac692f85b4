/// The composition root: creates every part of the daemon, connects the parts, and runs them until
/// a stop is requested.
#pragma once

#include <atomic>
#include <memory>

#include "core/base/result.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Main thread only, unless stated otherwise.
class App {
 public:
  /// Errors are those that waiting cannot repair: a configuration that makes no usable sensor, or a
  /// port or state folder in use. An absent camera or display is not an error.
  static Result<std::unique_ptr<App>> make(const LoadedConfig& loaded);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Starts the threads, shows holograms until `stop` is set, then stops everything in order.
  /// Errors: a missing privilege under `"realtime": "enforce"`, the failure of a thread that ends
  /// the daemon, or data that could not be written at the stop.
  Result<void> run(const std::atomic<bool>& stop);
  /// Thread-safe and async-signal-safe: requests a reload of the configuration file while `run`
  /// lasts.
  void reload();

 private:
  struct Parts;
  explicit App(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ovws
