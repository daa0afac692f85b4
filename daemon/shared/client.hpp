/// A client of the daemon's sockets: how `ovws` and `ovws-web` connect, call and subscribe.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/zmq/client.hpp"

namespace ovws::cli {

// Exit codes.
constexpr int kOk = 0;
constexpr int kError = 1;     ///< the daemon or the command returned an error
constexpr int kUsage = 2;     ///< the command line is wrong
constexpr int kNoDaemon = 3;  ///< no daemon answered in time

/// Options that all subcommands share.
struct Common {
  std::string endpoint = "tcp://127.0.0.1:7702";
  std::string key_path;    ///< empty: systemd credential ovws.key, or no keys
  std::string server_key;  ///< the daemon's; empty: as in the key file
  bool json = false;
  double timeout_s = 3.0;
};

/// Prints on standard output. A failure stays in ferror(stdout); `main` turns it into an exit code.
template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = fmt::format(format, std::forward<Args>(args)...);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

struct CallFailure {
  bool answered = false;  ///< false: no reply within the timeout
  nlohmann::json error;   ///< JSON-RPC error object; with `answered` false only "message"
};

/// A failure that this program found, in the form of an error of the daemon, without its code.
CallFailure failure(std::string message);
CallFailure failure(const Error& error);

/// Calls a method and returns its result. Blocks for at most `common.timeout_s`. `binary` receives
/// the reply's binary frame, if both are there; else it stays.
tl::expected<nlohmann::json, CallFailure> call(const Common& common, const std::string& method,
                                               const nlohmann::json& params,
                                               std::vector<std::byte>* binary = nullptr);

/// Calls several methods without params in one JSON-RPC batch and returns their results in order.
/// If one method fails, the whole call fails.
tl::expected<std::vector<nlohmann::json>, CallFailure> call_all(
    const Common& common, const std::vector<std::string>& methods);

/// Empty for "tcp://HOST:PORT" and "ipc://PATH", otherwise an error text. ZeroMQ accepts further
/// forms, but the daemon uses only these two.
std::string check_endpoint(const std::string& endpoint);

/// Prints the failure on stderr (as JSON on stdout with --json); returns kError or kNoDaemon.
int report_failure(const Common& common, const CallFailure& failure);

/// Prints an error on stderr (as JSON on stdout with --json) and returns kError.
int report(const Common& common, const Error& error);

/// Asks the daemon for a stream's endpoint (`key`: "endpoint" or "image_endpoint"), and subscribes
/// to topics there with this client's keys. Replaces the host so that this client can reach it.
tl::expected<Subscriber, CallFailure> open_stream(const Common& common, const char* key,
                                                  const std::vector<std::string>& topics,
                                                  int receive_queue);

/// The sentence of the verdict in a wavefront or spots message.
std::string verdict_text(const nlohmann::json& message);

/// Why the frame is not valid; `status`: the newest status, which has details of some verdicts.
std::string why_not_valid(const nlohmann::json& message, const nlohmann::json& status);

}  // namespace ovws::cli
