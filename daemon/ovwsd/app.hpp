/// The composition root: makes every part, gives each what it needs, and runs them until told to
/// stop.
#pragma once

#include <atomic>
#include <memory>

#include "core/base/result.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Main thread only, but for what says otherwise.
class App {
 public:
  /// Errors say what at start-up waiting cannot repair: a configuration that makes no sensor, a
  /// port or a state folder in use, a missing privilege under `"realtime": "enforce"`. A camera or
  /// a display that is absent is no error.
  static Result<std::unique_ptr<App>> make(const LoadedConfig& loaded);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  /// Shows holograms until `stop` is set, then stops everything in order.
  Result<void> run(const std::atomic<bool>& stop);
  /// Any thread, also a signal handler's: the configuration's file is read again while `run` lasts.
  void reload();

 private:
  struct Parts;
  explicit App(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ovws
