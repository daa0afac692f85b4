/// The registration on the disk: kept when it is measured, dropped when it is cleared, found again
/// at the start.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// One thread at a time. Only `load` waits for the disk.
class RegistrationArchive {
 public:
  RegistrationArchive(const SlmGeometry& slm, DaemonStore& store, Events& events)
      : slm_(slm), store_(store), events_(events) {}

  /// The one that was kept, if it is of this SLM. An event says when it was taken and its checksum,
  /// or why it is not used.
  std::optional<Registration> load();
  /// Of this camera, if it is known. An event says so, or why it will not survive a restart.
  /// `told` in the disk thread, when it was tried, and when it is kept after all.
  void keep(const Registration& registration, const std::optional<CameraInfo>& camera,
            std::function<void(const std::string& sha256)> told);
  /// `told` in the disk thread; an error: it is still on the disk.
  void drop(DaemonStore::Dropped told);
  /// Whether both cameras are known and differ.
  bool is_of_another(const std::optional<CameraInfo>& camera) const;

 private:
  Result<Registration> use(const nlohmann::json& content);

  SlmGeometry slm_;
  DaemonStore& store_;
  Events& events_;
  nlohmann::json camera_;  ///< that it was measured with; null: not known
};

}  // namespace ovws
