/// Thread pool for blocking calls to the daemon, with a first-come, first-served queue of browsers.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "daemon/web/http.hpp"

namespace ovws::web {

/// Everything except the calls themselves runs in the server's thread.
class Callers {
 public:
  using Call = std::function<std::string()>;

  /// Runs `call` in a thread of the pool and returns its result, first come, first served. None if
  /// the browser disconnected before its turn; the call is then not made.
  Task<std::optional<std::string>> carry_out(tcp::socket& browser, const Call& call);

  /// Waits for the running calls.
  void join() { threads_.join(); }

 private:
  using Numbers = std::set<std::uint64_t>;

  /// Waits for this number's turn. False: the browser has disconnected.
  Task<bool> turn(tcp::socket& browser, std::uint64_t number);

  static constexpr std::size_t kCalls = 4;  ///< concurrent calls
  net::thread_pool threads_{kCalls};
  std::uint64_t next_ = 0;
  Numbers waiting_, under_way_;
};

}  // namespace ovws::web
