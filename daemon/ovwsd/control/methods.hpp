/// Every method of the control socket: its name, who may call it, what it needs of the daemon's
/// state, and who answers it.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/control/state_machine.hpp"
#include "daemon/ovwsd/control/services.hpp"
#include "proto/requests.hpp"
#include "proto/rpc.hpp"

namespace ovws {

/// Answers one call, exactly once, from any thread, now or later. Called in the control thread;
/// must not wait. The params have passed the row's check.
using MethodCall = void (*)(Services& services, const nlohmann::json& params, RpcReply reply);

/// Errc::invalid, with the key at fault, unless these are params of the method.
using ParamsCheck = Result<void> (*)(const nlohmann::json& params);

template <class P>
Result<void> decodes(const nlohmann::json& params) {
  const auto decoded = decode_params<P>(params);
  if (!decoded) return fail(decoded.error());
  return {};
}

struct Method {
  const char* name;
  Role role;  ///< that a client must have at least
  Action action;
  MethodCall call;
  ParamsCheck check = decodes<Nothing>;
};

// One table a room; a new method is one function and one row.
std::span<const Method> system_methods();
std::span<const Method> camera_methods();
std::span<const Method> sensor_methods();
std::span<const Method> loop_methods();
std::span<const Method> calibration_methods();
std::span<const Method> reference_methods();
std::span<const Method> slm_methods();
std::span<const Method> refine_methods();
std::span<const Method> record_methods();
std::span<const Method> config_methods();
std::span<const Method> experiment_methods();

/// Finds the method and calls it if the client's key (empty where none is asked for) permits it,
/// the params are valid and the daemon's state allows it, asked in this order: a typo is reported
/// also when the state does not allow the call. An unknown method is answered with the nearest
/// known one.
void dispatch(Services& services, const std::string& key, const std::string& method,
              const nlohmann::json& params, RpcReply reply);
std::vector<std::string> method_names();
/// "read" or "control" of each method.
std::vector<std::pair<std::string, std::string>> method_roles();

/// The end of every handler: a result, or the error of the same words.
inline RpcAnswer failed(const Error& error) {
  return tl::make_unexpected(rpc_failure(error));
}

}  // namespace ovws
