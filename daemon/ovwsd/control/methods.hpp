/// What answers each method of the control socket: its row says who may call it, what it needs of
/// the daemon's state, and the function. Names and types are in proto/methods.hpp.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "core/control/state_machine.hpp"
#include "daemon/ovwsd/control/services.hpp"
#include "proto/methods.hpp"
#include "proto/rpc.hpp"

namespace ovws {

/// The same error, as the failure of a call.
inline RpcAnswer failed(const Error& error) {
  return tl::make_unexpected(rpc_failure(error));
}

/// Answers one call with an R or an error, exactly once, from any thread. Copies answer the same.
template <class R>
class Reply {
 public:
  explicit Reply(RpcReply reply) : reply_(std::move(reply)) {}
  void operator()(const R& result) const { reply_(to_json(result)); }
  /// JSON that has the fields of R.
  void operator()(JsonOf<R> result) const { reply_(std::move(result.json)); }
  void operator()(const Error& error) const { reply_(failed(error)); }
  template <class Value>
  void operator()(const Result<Value>& result) const {
    if (!result) return (*this)(result.error());
    (*this)(*result);
  }

 private:
  RpcReply reply_;
};

/// Answers jobs that start with their number.
inline auto with_number(Reply<JobNumber> reply) {
  return [reply = std::move(reply)](Result<int> job) {
    if (!job) return reply(job.error());
    reply(JobNumber{*job});
  };
}

struct MethodRow {
  const char* name;
  Role role;  ///< that a client must have at least
  Action action;
  /// Decodes the params, asks whether the daemon's state allows the action, and calls the function.
  void (*call)(const MethodRow& row, Services& services, const nlohmann::json& params,
               RpcReply reply);
};

/// The row of one of proto/methods.hpp. `answer(services, params, Reply<R>)` is called in the
/// control thread and must not wait; it answers now or later. Of a method without params:
/// `answer(services, Reply<R>)`.
template <const auto& method, auto answer>
constexpr MethodRow row(Role role, Action action) {
  using M = std::remove_cvref_t<decltype(method)>;
  using P = typename M::Params;
  return {
      method.name, role, action,
      [](const MethodRow& row, Services& services, const nlohmann::json& params, RpcReply reply) {
        const auto decoded = decode_params<P>(params);
        if (!decoded) return reply(failed(decoded.error()));
        if (const auto allowed = services.state.check(row.action); !allowed) {
          return reply(failed(allowed.error()));
        }
        Reply<typename M::Result> typed(std::move(reply));
        if constexpr (std::is_same_v<P, Nothing>) {
          answer(services, std::move(typed));
        } else {
          answer(services, *decoded, std::move(typed));
        }
      }};
}

// One table a room; a new method is one function and one row.
std::span<const MethodRow> system_methods();
std::span<const MethodRow> camera_methods();
std::span<const MethodRow> sensor_methods();
std::span<const MethodRow> loop_methods();
std::span<const MethodRow> calibration_methods();
std::span<const MethodRow> reference_methods();
std::span<const MethodRow> slm_methods();
std::span<const MethodRow> refine_methods();
std::span<const MethodRow> record_methods();
std::span<const MethodRow> config_methods();
std::span<const MethodRow> experiment_methods();

/// Finds the method and calls it if the client's key (empty where none is asked for) permits it,
/// the params are valid and the daemon's state allows it, asked in this order: a typo is reported
/// also when the state does not allow the call. An unknown method is answered with the nearest
/// known one.
void dispatch(Services& services, const std::string& key, const std::string& method,
              const nlohmann::json& params, RpcReply reply);
std::vector<std::string> method_names();
std::vector<std::pair<std::string, Role>> method_roles();

}  // namespace ovws
