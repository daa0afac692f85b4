/// A call to a daemon as the command line makes it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/cli/commands.hpp"
#include "drivers/zmq/client.hpp"

namespace ovws::cli {

struct CallFailure {
  bool answered = false;  ///< false: nobody did, in time
  nlohmann::json error;   ///< JSON-RPC error object; with `answered` false only "message"
};

/// The method's result.
tl::expected<nlohmann::json, CallFailure> call(const Common& common, const std::string& method,
                                               const nlohmann::json& params);

/// The results of several methods without params, in their order, by one request. A method that is
/// refused fails them all.
tl::expected<std::vector<nlohmann::json>, CallFailure> call_all(
    const Common& common, const std::vector<std::string>& methods);

/// --endpoint, --key and --server-key.
void add_connection_options(CLI::App& app, Common& common);

/// Tells the failure, and returns kError or kNoDaemon.
int report_failure(const Common& common, const CallFailure& failure);

/// A stream's endpoint as the daemon has it configured ("endpoint" or "image_endpoint").
tl::expected<std::string, CallFailure> stream_endpoint(const Common& common, const char* key);

/// Some topics of a stream, with this client's keys.
Result<Subscriber> subscribe(const Common& common, const std::string& endpoint,
                             const std::vector<std::string>& topics, int receive_queue);

/// Why a wavefront or spots message that is not valid is not; `status`: the newest status.
std::string why_not_valid(const nlohmann::json& message, const nlohmann::json& status);

}  // namespace ovws::cli
