/// Who may look and who may control, and what is refused: a page of another origin, a name that
/// somebody made point here (DNS rebinding), a request without the token.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::web {

enum class Right { page, look, control };  ///< each holds those before it

enum class Refusal { malformed, host, origin, method, path, size, token, right, command, full };
constexpr std::size_t kRefusals = 10;
std::string_view refusal_name(Refusal refusal);
/// What a person can do about it.
std::string_view refusal_reason(Refusal refusal);
/// The HTTP status that says it.
int refusal_status(Refusal refusal);

/// Of a request's head; empty where the request has none.
struct RequestHead {
  std::string method;
  std::string target;
  std::string host;
  std::string origin;
  std::string fetch_site;     ///< Sec-Fetch-Site
  std::string authorization;  ///< "Bearer TOKEN"
  std::optional<std::uint64_t> content_length;
  bool chunked = false;
};

struct Tokens {
  std::string look;
  std::string control;  ///< empty: nobody may control
};

/// Tokens of 128 random bits.
Tokens make_tokens(bool control);

/// What each path takes. None: there is no such path.
struct Route {
  std::string_view method;
  Right right;
};
std::optional<Route> route_of(std::string_view path);

constexpr std::uint64_t kMostBodyBytes = 64 * 1024;

/// Immutable, thread-safe.
class Access {
 public:
  /// `hosts`: what a browser may call this server, "127.0.0.1:7704", "localhost:7704".
  Access(std::vector<std::string> hosts, Tokens tokens);

  /// The right that the request has proven, which is at least that of its path.
  tl::expected<Right, Refusal> judge(const RequestHead& head) const;

 private:
  Right proven(std::string_view authorization) const;

  std::vector<std::string> hosts_;
  Tokens tokens_;
};

/// Counts all refusals, and writes at most one a second and kind to the log. Thread-safe.
class RefusalLog {
 public:
  void add(Refusal refusal, const RequestHead& head, const std::string& peer);
  /// {name: how many since the start}
  nlohmann::json counts() const;

 private:
  struct Kind {
    std::uint64_t count = 0;
    std::uint64_t untold = 0;
    std::chrono::steady_clock::time_point told{};
  };
  mutable std::mutex mutex_;
  std::array<Kind, kRefusals> kinds_;
};

}  // namespace ovws::web
