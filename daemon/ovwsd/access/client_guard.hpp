/// Lets clients in by their keys, and says what each may: the gate's memory.
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

/// Errors as the daemon's start would give them: an endpoint that other machines reach without
/// keys, a file of keys or clients that cannot be used. The field is the configuration's key.
Result<void> check_security(const Config& config);
/// The part of check_security that is about the file of clients.
Result<void> check_clients(const std::string& path);

/// Every question has the disk thread look first whether the clients' file has changed, and read it
/// again; it waits a tenth of a second at most, and while the disk has not answered not at all:
/// then who could connect before still can. A key that is no longer there is refused from then on,
/// and all streams end, so that every client has to show its key again. A file that cannot be used
/// changes nothing, and an event says so.
class ClientGuard {
 public:
  /// Without keys in the configuration it has no gate, and everybody may everything. Errors as of
  /// check_security.
  static Result<std::unique_ptr<ClientGuard>> make(const SecurityConfig& config, Counters& counters,
                                                   Events& events, Disk& disk);
  ClientGuard(const ClientGuard&) = delete;
  ClientGuard& operator=(const ClientGuard&) = delete;

  /// None without keys.
  Gate* gate() { return gate_.get(); }
  /// The daemon's own, for clients; empty without keys.
  const std::string& public_key() const { return public_key_; }

  /// Thread-safe: what the client with this key may; refused (Errc::refused) and counted if the key
  /// was withdrawn, be it just now.
  Result<Role> role_of(const std::string& key);
  /// Status thread, each turn: tells who was not let in, seldom enough that nobody can flood the
  /// log, and has the disk thread look at the file once a second.
  void turn();

 private:
  /// What tells one state of a file from another.
  struct Stamp {
    std::int64_t modified_ns = 0, changed_ns = 0, size = 0;
    std::uint64_t inode = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  struct Rejected {
    std::uint64_t count = 0;
    std::string why;  ///< of the last one
  };
  ClientGuard(SecurityConfig config, Counters& counters, Events& events, Disk& disk);
  static Stamp stamp_of(const std::string& path);
  bool knows(const std::string& key) const;
  void reject(const std::string& why);
  Result<void> read_list();
  std::uint64_t ask_to_look();
  void look_first();
  void look();
  void reload_if_changed();
  void tell_rejected();
  void tell_rebound(const std::string& endpoint, const Result<void>& bound);

  SecurityConfig config_;
  Counters& counters_;
  Events& events_;
  Disk& disk_;
  std::string public_key_;
  Stamp stamp_;  ///< disk thread
  std::mutex looking_;
  std::condition_variable looked_;
  std::uint64_t looks_asked_ = 0, looks_done_ = 0;  ///< under looking_
  bool late_ = false;                               ///< under looking_: the disk has not answered
  Guarded<std::shared_ptr<const ClientList>> list_;
  Guarded<Rejected> rejected_;
  std::int64_t next_look_ns_ = 0, next_tell_ns_ = 0;  ///< status thread
  std::unique_ptr<Gate> gate_;
};

}  // namespace ovws
