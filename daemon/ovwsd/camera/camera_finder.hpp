/// Discovers cameras, in a thread of its own, because that takes a second.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "proto/tables/devices.hpp"

namespace ovws {

/// Agent of the discover thread. One discovery answers all requests that wait.
class CameraFinder : public Agent {
 public:
  using Listed = std::function<void(const std::vector<CameraListing>&)>;
  /// `config`: returns the camera's configuration in use; any thread.
  explicit CameraFinder(std::function<CameraConfig()> config) : config_(std::move(config)) {}

  /// Calls `done` in the discover thread with the cameras that answer. Thread-safe; after the
  /// agent's end `done` is not called.
  void list(Listed done);
  /// Discovers cameras, too, and calls `done` with whether there is one with this id, serial number
  /// or address. Errors: see check_camera.
  void find(const std::string& id, std::function<void(Result<void>)> done);

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

 private:
  std::function<CameraConfig()> config_;
  std::vector<Listed> waiting_;  ///< for the next discovery
  Mailbox mailbox_;
};

}  // namespace ovws
