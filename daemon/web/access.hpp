/// Access control: bearer tokens for viewing and control. Refuses cross-origin requests, unknown
/// host names (DNS rebinding) and requests without a token.
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

enum class Right { page, look, control };  ///< each right includes the previous ones

enum class Refusal {
  malformed,
  host,
  origin,
  method,
  path,
  size,
  token,
  right,
  command,
  full,
  ticket,
  downloads
};
constexpr std::size_t kRefusals = 12;
struct RefusalRow {
  std::string_view name;
  std::string_view reason;  ///< error message with the remedy
  int status;               ///< HTTP status code
};
const RefusalRow& row_of(Refusal refusal);

/// The checked fields of a request header; empty if the request lacks them.
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
  std::string control;  ///< empty: control is disabled
};

/// 128 random bits as text.
std::string random_token();
/// Whether `given` is the secret. Compares in constant time, against timing attacks.
bool is_secret(std::string_view given, const std::string& secret);
/// Makes random tokens; the control token only if `control` is true.
Tokens make_tokens(bool control);

/// HTTP method and right that a path requires. `route_of` returns none if the path does not exist.
/// A path with two methods has a route for each; other methods get that of GET.
struct Route {
  std::string_view method;
  Right right;
};
std::optional<Route> route_of(std::string_view path, std::string_view method = "GET");

/// Path of a part of the camera's newest image, followed by the query of parse_image_part.
constexpr std::string_view kImagePath = "/image?";

constexpr std::uint64_t kMaxBodyBytes = 64 * 1024;

/// Checks requests by host name, origin and token. Immutable and thread-safe.
class Access {
 public:
  /// `hosts`: accepted values of the Host header, e.g. "127.0.0.1:7704", "localhost:7704".
  Access(std::vector<std::string> hosts, Tokens tokens);

  /// Checks a request. Returns the right that the request's token grants, which is at least the
  /// right that the path requires.
  tl::expected<Right, Refusal> judge(const RequestHead& head) const;

 private:
  Right granted_right(std::string_view authorization) const;

  std::vector<std::string> hosts_;
  Tokens tokens_;
};

/// Counts all refusals and logs at most one per second and kind. Thread-safe.
class RefusalLog {
 public:
  void add(Refusal refusal, const RequestHead& head, const std::string& peer);
  /// Number of refusals since the start, as {refusal name: count}.
  nlohmann::json counts() const;

 private:
  struct Kind {
    std::uint64_t count = 0;
    std::uint64_t unlogged = 0;
    std::chrono::steady_clock::time_point last_logged{};
  };
  mutable std::mutex mutex_;
  std::array<Kind, kRefusals> kinds_;
};

}  // namespace ovws::web
