/// The method table of the control socket (JSON-RPC). Each row holds the role that a caller needs,
/// the action that the daemon's state must allow, and the handler. Names and types are in
/// proto/methods.hpp.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "core/control/state_machine.hpp"
#include "daemon/ovwsd/actor/state_keeper.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/methods.hpp"
#include "proto/rpc.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/job.hpp"

namespace ovws {

// Include the headers of the parts that you use: all of them take seconds to compile.
class CameraActor;
class ClientGuard;
class ClosedLoop;
struct Config;
class Counters;
class Disk;
class ExperimentArchive;
class Jobs;
class LiveRefiner;
struct LoadedConfig;
class Procedures;
class Recorder;
class SensorKeeper;
class SlmLoop;
class StateKeeper;
class StatusReporter;

/// The parts of the daemon that the handlers use.
struct Services {
  const Config& config;                 ///< as the daemon was started with
  const Guarded<LoadedConfig>& loaded;  ///< as last loaded: at the start, or by a reload
  StateKeeper& state;
  CameraActor& camera;
  SensorKeeper& keeper;
  Jobs& jobs;
  Procedures& procedures;
  ExperimentArchive& experiments;
  ClosedLoop& loop;
  LiveRefiner& refiner;
  Recorder& recorder;
  StatusReporter& status;
  SlmLoop& slm;
  Counters& counters;
  ClientGuard& clients;
  Disk& disk;
};

/// Converts an error to the failure of a call.
inline RpcAnswer failed(const Error& error) {
  return tl::make_unexpected(rpc_failure(error));
}

/// The reply to one call: an R or an error, exactly once, from any thread. Copies answer the same
/// call.
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

/// Replies with the number of the job that has started.
inline auto with_job_number(Reply<JobNumber> reply) {
  return [reply = std::move(reply)](Result<int> job) {
    if (!job) return reply(job.error());
    reply(JobNumber{*job});
  };
}

struct MethodRow {
  const char* name;
  Role role;  ///< the client needs at least this role
  Action action;
  /// Decodes the params, checks that the daemon's state allows the action, and calls the handler.
  void (*call)(const MethodRow& row, Services& services, const nlohmann::json& params,
               RpcReply reply);
};

/// Makes the row of a method in proto/methods.hpp. Its handler `answer(services, params,
/// Reply<R>)`, or without params `answer(services, Reply<R>)`, is called in the control thread and
/// must not block; it replies at once or later.
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

// One file for each part of the daemon; a new method is one function and one row.
std::span<const MethodRow> sensor_methods();
std::span<const MethodRow> experiment_methods();
std::span<const MethodRow> system_methods();

/// Calls a method for a client. Checks the client's key (empty without `security`) and role, then
/// the params, then the daemon's state: a typo is reported even if the state does not allow the
/// call. The error for an unknown method names the nearest known one.
void dispatch(Services& services, const std::string& key, const std::string& method,
              const nlohmann::json& params, RpcReply reply);
/// All methods by name, with the role that each needs.
std::vector<std::pair<std::string, Role>> method_roles();

}  // namespace ovws
