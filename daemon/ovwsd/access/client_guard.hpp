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

/// The security check of the daemon's start. Errors: an endpoint that other machines can reach
/// without keys, or a key or client file that cannot be used. The field is the configuration key.
Result<void> check_security(const Config& config);
/// The part of check_security that checks the client file.
Result<void> check_clients(const std::string& path);

/// Reloads the client list when its file changes. Each authentication first asks the disk thread to
/// check the file (stat), and waits for that for 100 ms at most; while an earlier check is late it
/// does not wait. Until the disk answers, the previous list stays active. A key that was removed
/// from the file is refused from then on, and all streams are closed so that every client
/// authenticates again. A file that cannot be used changes nothing; an event reports it.
class ClientGuard {
 public:
  /// Without keys in the configuration there is no gate, and every client has the role `control`.
  /// Errors: see check_security.
  static Result<std::unique_ptr<ClientGuard>> make(const SecurityConfig& config, Counters& counters,
                                                   Events& events, Disk& disk);
  ClientGuard(const ClientGuard&) = delete;
  ClientGuard& operator=(const ClientGuard&) = delete;

  /// Null without keys.
  Gate* gate() { return gate_.get(); }
  /// The daemon's public key, which its clients need; empty without keys.
  const std::string& public_key() const { return public_key_; }

  /// Thread-safe: the role of the client with this key. Errc::refused, and counted as a rejection,
  /// if the key was withdrawn, even a moment ago.
  Result<Role> role_of(const std::string& key);
  /// Status thread, each turn: has the disk thread check the client file once a second, and reports
  /// rejected clients in at most one event per 10 s, so that they cannot flood the log.
  void turn();

 private:
  /// Identifies one version of a file.
  struct Stamp {
    std::int64_t modified_ns = 0, changed_ns = 0, size = 0;
    std::uint64_t inode = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  struct Rejected {
    std::uint64_t count = 0;
    std::string why;  ///< of the last rejection
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
  Stamp stamp_;  ///< disk thread
  std::mutex check_mutex_;
  std::condition_variable checked_;
  std::uint64_t checks_requested_ = 0, checks_done_ = 0;  ///< under check_mutex_
  bool late_ = false;  ///< under check_mutex_: the disk has not answered
  Guarded<std::shared_ptr<const ClientList>> list_;
  Guarded<Rejected> rejected_;
  std::int64_t next_check_ns_ = 0, next_report_ns_ = 0;  ///< status thread
  std::unique_ptr<Gate> gate_;
};

}  // namespace ovws
