/// Client authentication: decides by public key who may connect, and with which role. The role that
/// each method needs is in its row in daemon/ovwsd/control.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "config/config.hpp"
#include "core/rt/counters.hpp"
#include "daemon/ovwsd/access/client_list.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/shared/guarded.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// Security check at the start of the daemon. Fails if other machines can reach an endpoint without
/// keys, or if a key file or the client file cannot be used. The error's field is the configuration
/// key.
Result<void> check_security(const Config& config);
/// Client file check of check_security: whether the file at `path` can be used.
Result<void> check_clients(const std::string& path);

/// Client list, reloaded when its file changes. Each authentication asks the disk thread to check
/// the file (stat), and waits up to 100 ms. While an earlier check is late, it does not wait. Until
/// the disk answers, the previous list stays active. A key that was removed from the file is
/// refused from then on, and all streams are closed so that every client authenticates again. If
/// the new file cannot be used, the previous list stays active and an event reports the error.
class ClientGuard {
 public:
  /// Makes the guard. If the configuration has no keys, clients are not authenticated and every
  /// client has the role `control`. Errors: see check_security.
  static Result<std::unique_ptr<ClientGuard>> make(const SecurityConfig& config, Counters& counters,
                                                   Events& events, Disk& disk);
  ClientGuard(const ClientGuard&) = delete;
  ClientGuard& operator=(const ClientGuard&) = delete;

  /// The gate that authenticates clients; null if the configuration has no keys.
  Gate* gate() { return gate_.get(); }
  /// The daemon's public key, which clients need to connect; empty if there are no keys.
  const std::string& public_key() const { return public_key_; }

  /// Client role for this public key. Thread-safe. If the key is no longer in the client list,
  /// fails with Errc::refused and counts a rejection.
  Result<Role> role_of(const std::string& key);
  /// Status thread, in each turn: requests a check of the client file once a second. Reports
  /// rejected clients in at most one event per 10 s, so that they cannot flood the log.
  void turn();

 private:
  /// File stamp: identifies one version of the client file.
  struct Stamp {
    std::int64_t modified_ns = 0, changed_ns = 0, size = 0;
    std::uint64_t inode = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  struct Rejected {
    std::uint64_t count = 0;
    std::string why;  ///< reason of the last rejection
  };
  ClientGuard(SecurityConfig config, Counters& counters, Events& events, Disk& disk);
  static Stamp stamp_of(const std::string& path);
  bool knows(const std::string& key) const;
  void reject(const std::string& why);
  Result<void> read_list();
  std::uint64_t request_check();
  void check_file_first();
  void check_file();
  void reload_if_changed();
  void report_rejected();
  void report_rebound(const std::string& endpoint, const Result<void>& bound);

  SecurityConfig config_;
  Counters& counters_;
  Events& events_;
  Disk& disk_;
  std::string public_key_;
  Stamp stamp_;  ///< of the client file as last read; disk thread only
  std::mutex check_mutex_;
  std::condition_variable checked_;
  std::uint64_t checks_requested_ = 0, checks_done_ = 0;  ///< guarded by check_mutex_
  bool late_ = false;  ///< the last check timed out; guarded by check_mutex_
  Guarded<std::shared_ptr<const ClientList>> list_;
  Guarded<Rejected> rejected_;
  std::int64_t next_check_ns_ = 0, next_report_ns_ = 0;  ///< CLOCK_MONOTONIC; status thread only
  std::unique_ptr<Gate> gate_;
};

}  // namespace ovws
