#include "daemon/shared/client.hpp"

#include <netdb.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "daemon/shared/key_file.hpp"
#include "daemon/shared/verdict_sentence.hpp"
#include "proto/endpoint.hpp"
#include "proto/json_text.hpp"
#include "proto/measurable_image.hpp"
#include "proto/rpc.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr const char* kCredential = "ovws.key";  // as in the systemd units
constexpr const char* kForeignReply =
    "the reply is not one of ovwsd: check that the endpoint is its control endpoint, and that ovws "
    "has "
    "the same version";

/// Whether the host exists. If the name service does not answer, it may.
bool may_exist(std::string host) {
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  addrinfo* found = nullptr;
  const int failure = getaddrinfo(host.c_str(), nullptr, nullptr, &found);
  if (failure == 0) freeaddrinfo(found);
  return failure != EAI_NONAME;
}

tl::unexpected<CallFailure> no_answer(const std::string& why) {
  return tl::make_unexpected(CallFailure{false, {{"message", why}}});
}

/// The client's keys from options or systemd credentials; none if there is neither a key option nor
/// a credential.
Result<std::optional<ClientKeys>> keys_of(const Common& common) {
  const std::string path = common.key_path.empty() ? credential_path(kCredential) : common.key_path;
  if (path.empty() && common.server_key.empty()) return std::nullopt;
  if (path.empty()) {
    return fail(Errc::invalid, "--key", "--server-key requires --key FILE");
  }
  const auto file = load_key_file(path);
  if (!file) return fail(file.error());
  const std::string server_key = common.server_key.empty() ? file->server_key : common.server_key;
  if (!server_key.empty()) return ClientKeys{file->pair, server_key};
  return fail(
      Errc::invalid, "--server-key",
      "no server key: give the daemon's public key, which ovws keygen printed for it, or add it as "
      "\"server_key\" to " +
          path);
}

/// Translates a stream's bind address for this client. For wildcard and loopback addresses it uses
/// the host through which the control socket was reached.
std::string reachable_endpoint(const std::string& stream, const std::string& control) {
  const std::string bound = host_of(local_endpoint(stream));
  const std::string reached = host_of(control);
  const bool own_name = bound == "127.0.0.1" || bound == "[::1]";
  if (!own_name || reached.empty()) return stream;
  return "tcp://" + reached + stream.substr(stream.rfind(':'));
}

/// Sends a JSON-RPC request or batch and returns the parsed reply.
tl::expected<json, CallFailure> ask(const Common& common, const json& request,
                                    std::vector<std::byte>* binary = nullptr) {
  const auto keys = keys_of(common);
  if (!keys) return no_answer(keys.error().reason);
  auto client = ControlClient::connect(common.endpoint, *keys);
  if (!client) return no_answer(client.error().reason);
  const auto reply =
      client->request(json_text(request),
                      std::chrono::milliseconds(std::int64_t(1000.0 * common.timeout_s)), binary);
  if (!reply) return no_answer(reply.error().reason);
  return json_of(*reply);
}

json request_of(int id, const std::string& method, const json& params) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}};
}

tl::expected<json, CallFailure> result_of(json& answer) {
  if (answer.is_object() && answer.contains("result")) return std::move(answer["result"]);
  if (answer.is_object() && answer.contains("error")) {
    return tl::make_unexpected(CallFailure{true, std::move(answer["error"])});
  }
  return tl::make_unexpected(failure(kForeignReply));
}

}  // namespace

std::string check_endpoint(const std::string& endpoint) {
  const std::string host = host_of(endpoint);
  if (endpoint_fault(endpoint)) {
    return endpoint + " is not an endpoint: use tcp://HOST:PORT, e.g. tcp://127.0.0.1:7702";
  }
  if (host.empty() || may_exist(host)) return {};
  return endpoint + ": there is no host \"" + host + "\"";
}

CallFailure failure(std::string message) {
  return {true, {{"message", std::move(message)}}};
}

CallFailure failure(const Error& error) {
  RpcFailure as_reply = rpc_failure(error);
  return {true, {{"message", std::move(as_reply.message)}, {"data", std::move(as_reply.data)}}};
}

tl::expected<json, CallFailure> call(const Common& common, const std::string& method,
                                     const json& params, std::vector<std::byte>* binary) {
  auto answer = ask(common, request_of(1, method, params), binary);
  if (!answer) return answer;
  return result_of(*answer);
}

tl::expected<std::vector<json>, CallFailure> call_all(const Common& common,
                                                      const std::vector<std::string>& methods) {
  json batch = json::array();
  for (const auto& method : methods) {
    batch.push_back(request_of(int(batch.size()), method, json::object()));
  }
  auto answers = ask(common, batch);
  if (!answers) return tl::make_unexpected(answers.error());
  std::vector<json> results(methods.size());
  if (!answers->is_array() || answers->size() != methods.size()) {
    return tl::make_unexpected(failure(kForeignReply));
  }
  for (json& answer : *answers) {
    auto result = result_of(answer);
    if (!result) return tl::make_unexpected(result.error());
    const json id = answer.value("id", json());
    if (!id.is_number_unsigned() || id >= results.size()) {
      return tl::make_unexpected(failure(kForeignReply));
    }
    results[id.get<std::size_t>()] = std::move(*result);
  }
  return results;
}

int report_failure(const Common& common, const CallFailure& failure) {
  if (common.json) {
    print("{}\n", json_text(json{{"error", failure.error}}));
  } else {
    fmt::print(stderr, "ovws: {}\n", failure.error.value("message", "unknown error"));
  }
  return failure.answered ? kError : kNoDaemon;
}

tl::expected<Subscriber, CallFailure> open_stream(const Common& common, const char* key,
                                                  const std::vector<std::string>& topics,
                                                  int receive_queue) {
  const auto config = call(common, "config.get", json::object());
  if (!config) return tl::make_unexpected(config.error());
  const json::json_pointer at(std::string("/stream/") + key);
  if (!config->contains(at) || !config->at(at).is_string()) {
    return tl::make_unexpected(failure("the daemon's reply to config.get has no stream." +
                                       std::string(key) + ": install the same version of both"));
  }
  const auto endpoint = reachable_endpoint(config->at(at).get<std::string>(), common.endpoint);
  const auto keys = keys_of(common);
  if (!keys) return tl::make_unexpected(failure(keys.error()));
  return Subscriber::connect(endpoint, topics, receive_queue, *keys)
      .map_error([](const Error& error) { return failure(error); });
}

std::string verdict_text(const json& message) {
  const auto& names = kNames<Verdict>();
  const auto name = std::ranges::find(names, message.value("verdict", ""));
  if (name == names.end()) return "it is not valid";
  return sentence_of(Verdict(name - names.begin()), message.value("tracked", 0),
                     message.value("subapertures", 0));
}

std::string why_not_valid(const json& message, const json& status) {
  const json& slm = status.at("slm");
  const auto pattern = slm.at("pattern").get<std::string>();
  if (pattern != "sensor") {
    const std::string what = pattern == "grating" ? "a grating" : "the pattern \"" + pattern + "\"";
    return "the SLM shows " + what + ": no wavefront is measured";
  }
  if (std::string why = why_not_measurable(status); !why.empty()) return why;
  // Once per second, the daemon names the other source, or the branch points' places.
  const std::string verdict = message.value("verdict", "");
  const json invalid = status.at("sensor").value("invalid", json());
  if (invalid.is_object() && invalid.contains("reason") &&
      (verdict == wire_name(Verdict::too_close) || verdict == wire_name(Verdict::branch_points))) {
    return invalid.at("reason");
  }
  return verdict_text(message);
}

int report(const Common& common, const Error& error) {
  return report_failure(common, failure(error));
}

}  // namespace ovws::cli
