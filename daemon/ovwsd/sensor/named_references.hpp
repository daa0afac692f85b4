/// References that a person has saved under a name.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/sensor_edit.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// Saved references: one state file each, of kind `saved-reference`. Thread-safe; callbacks are
/// called in the disk thread, or in the caller's if the disk takes no request.
class NamedReferences {
 public:
  static constexpr std::size_t kMax = 32;
  /// The references by name, without their mean images.
  using All = std::map<std::string, std::shared_ptr<const Reference>>;
  using Done = std::function<void(Result<void>)>;

  NamedReferences(DaemonStore& store, Events& events) : store_(store), events_(events) {}

  /// Reads all files; blocks on the disk. An event reports each that is not a reference.
  void load();
  All all() const;
  /// Writes a reference. Errc::refused: the name is taken, or there are kMax already.
  /// Errc::unavailable: there is no state folder, or the disk does not take it.
  void save(const std::string& name, std::shared_ptr<const Reference> reference, Done done);
  /// Reads a reference with its image. Errc::invalid, field "name": there is none of this name.
  void find(const std::string& name, std::function<void(Result<Reference>)> done);
  /// Deletes a reference. Errc::invalid, field "name": there is none of this name.
  void remove(const std::string& name, Done done);

 private:
  Result<void> add(const std::string& name, const Reference& reference);
  void forget(const std::string& name);

  DaemonStore& store_;
  Events& events_;
  mutable std::mutex mutex_;
  All all_;
};

/// Why a reference does not fit the present sensor and bench; empty: it fits. Prepare thread.
std::string misfit(const Reference& reference, const SensorEdit& now);

}  // namespace ovws
