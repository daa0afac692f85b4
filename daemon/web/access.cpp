#include "daemon/web/access.hpp"

#include <sodium.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "daemon/web/commission_desk.hpp"
#include "daemon/web/page_files.hpp"
#include "daemon/web/recordings.hpp"

namespace ovws::web {
namespace {

constexpr std::size_t kTokenBytes = 16;
constexpr std::size_t kMaxLoggedBytes = 80;
constexpr std::string_view kBearer = "Bearer ";

constexpr std::array<RefusalRow, kRefusals> kRows{{
    {"malformed", "the HTTP request is malformed or not supported", 400},
    {"host", "unknown host name: add it with ovws-web --allow-host", 421},
    {"origin", "requests from other sites are not allowed: open the link printed by ovws-web", 403},
    {"method", "this path requires another HTTP method", 405},
    {"path", "this path does not exist", 404},
    {"size", "requests need a Content-Length of at most 64 KiB", 413},
    {"token", "the token is missing or wrong: open the link printed by ovws-web", 401},
    {"right", "this link is for viewing only: use the control link of ovws-web --control", 403},
    {"command", "the page may not call this method: use ovws call", 403},
    {"full", "the maximum number of browsers is connected: close another page", 503},
    {"ticket",
     "this download's address was used, is too old, or is of another recording: press Download "
     "again",
     403},
    {"downloads", "the maximum number of downloads is running: wait until one has ended", 503},
}};

/// Truncated, with non-printable characters replaced, so that a request cannot forge log lines or
/// send terminal escape sequences.
std::string loggable(std::string_view text) {
  std::string shown(text.substr(0, kMaxLoggedBytes));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > kMaxLoggedBytes ? shown + "..." : shown;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  std::array<char, 2 * kTokenBytes + 1> text{};
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  return text.data();
}

bool is_secret(std::string_view given, const std::string& secret) {
  return !secret.empty() && given.size() == secret.size() &&
         sodium_memcmp(given.data(), secret.data(), secret.size()) == 0;
}

const RefusalRow& row_of(Refusal refusal) {
  return kRows[std::size_t(refusal)];
}

Tokens make_tokens(bool control) {
  return {random_token(), control ? random_token() : std::string{}};
}

std::optional<Route> route_of(std::string_view path, std::string_view method) {
  if (path == "/stream" || path == "/hologram.png") return Route{"GET", Right::look};
  if (path.starts_with(kImagePath)) return Route{"GET", Right::look};
  if (path == kCommissionPath && method == "POST") return Route{"POST", Right::control};
  if (path == kCommissionPath || path.starts_with(kCommissionPicturePath)) {
    return Route{"GET", Right::look};
  }
  if (path == "/recordings") return Route{"GET", Right::look};
  if (path == "/ticket") return Route{"POST", Right::look};
  // Without a token it takes a ticket, which Session checks.
  if (path.starts_with(kRecordingPath)) return Route{"GET", Right::page};
  if (path == "/rpc") return Route{"POST", Right::control};
  if (page_file(path)) return Route{"GET", Right::page};
  return std::nullopt;
}

Access::Access(std::vector<std::string> hosts, Tokens tokens)
    : hosts_(std::move(hosts)), tokens_(std::move(tokens)) {}

Right Access::granted_right(std::string_view authorization) const {
  if (!authorization.starts_with(kBearer)) return Right::page;
  const std::string_view given = authorization.substr(kBearer.size());
  if (is_secret(given, tokens_.control)) return Right::control;
  return is_secret(given, tokens_.look) ? Right::look : Right::page;
}

tl::expected<Right, Refusal> Access::judge(const RequestHead& head) const {
  const auto refuse = [](Refusal why) { return tl::make_unexpected(why); };
  if (std::find(hosts_.begin(), hosts_.end(), head.host) == hosts_.end()) {
    return refuse(Refusal::host);
  }
  // Browsers send Origin with every cross-origin request that is more than a plain GET.
  if (!head.origin.empty() && head.origin != "http://" + head.host &&
      head.origin != "https://" + head.host) {
    return refuse(Refusal::origin);
  }
  const bool foreign = head.fetch_site == "cross-site" || head.fetch_site == "same-site";
  const auto route = route_of(head.target, head.method);
  // Another site may link to the page itself, which contains no secret.
  if (foreign && !page_file(head.target)) return refuse(Refusal::origin);
  if (!route) return refuse(Refusal::path);
  if (head.method != route->method) return refuse(Refusal::method);
  if (head.chunked || head.content_length.value_or(0) > kMaxBodyBytes) {
    return refuse(Refusal::size);
  }
  const Right right = granted_right(head.authorization);
  if (right < route->right) {
    return refuse(right == Right::page ? Refusal::token : Refusal::right);
  }
  return right;
}

void RefusalLog::add(Refusal refusal, const RequestHead& head, const std::string& peer) {
  const auto now = std::chrono::steady_clock::now();
  std::uint64_t unlogged = 0;
  {
    const std::scoped_lock lock(mutex_);
    Kind& kind = kinds_[std::size_t(refusal)];
    ++kind.count;
    if (now - kind.last_logged < std::chrono::seconds(1)) {
      ++kind.unlogged;
      return;
    }
    kind.last_logged = now;
    unlogged = std::exchange(kind.unlogged, 0);
  }
  spdlog::warn("refused ({}): {} {} from {}, host \"{}\", origin \"{}\"{}", row_of(refusal).name,
               loggable(head.method), loggable(head.target), peer, loggable(head.host),
               loggable(head.origin),
               unlogged == 0 ? "" : fmt::format("; {} similar refusals not logged", unlogged));
}

nlohmann::json RefusalLog::counts() const {
  nlohmann::json counts = nlohmann::json::object();
  const std::scoped_lock lock(mutex_);
  for (std::size_t i = 0; i < kRefusals; ++i) counts[std::string(kRows[i].name)] = kinds_[i].count;
  return counts;
}

}  // namespace ovws::web
