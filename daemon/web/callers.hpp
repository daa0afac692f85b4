/// The few threads that wait for the daemon's answers, and the browsers that wait for one of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "daemon/web/http.hpp"

namespace ovws::web {

/// But for the calls themselves all happens in the server's thread.
class Callers {
 public:
  using Call = std::function<std::string()>;

  /// What `call` returns, made in a thread of this class; first come, first served. None if the
  /// browser closed its connection before its turn: then there was no call.
  Task<std::optional<std::string>> carry_out(tcp::socket& browser, const Call& call);

  /// Waits for the calls that are under way.
  void join() { threads_.join(); }

 private:
  using Numbers = std::set<std::uint64_t>;

  /// Whether it has come; else the browser has left.
  Task<bool> turn(tcp::socket& browser, std::uint64_t number);

  static constexpr std::size_t kCalls = 4;  ///< at a time
  net::thread_pool threads_{kCalls};
  std::uint64_t next_ = 0;
  Numbers waiting_, under_way_;
};

}  // namespace ovws::web
