/// The method table of the control socket (JSON-RPC). Each row holds the role that a caller needs,
/// the kind of request, for which the call has a lease, and the handler. Names and types are in
/// proto/methods.hpp.
#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "daemon/ovwsd/lease/leases.hpp"
#include "proto/methods.hpp"
#include "proto/rpc.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/job.hpp"

namespace ovws {

// Include only headers of the parts that you use: all parts together take seconds to compile.
class CameraActor;
class CameraFinder;
class ClientGuard;
class ClosedLoop;
struct Config;
class Corrector;
class Counters;
class Disk;
class Jobs;
class LiveRefiner;
class FrameGrabs;
class Library;
class NamedReferences;
class PreparedLattices;
class Presentations;
class Procedures;
class Recorder;
class SensorKeeper;
class Settings;
class SlmLoop;
class StatusReporter;

/// The parts of the daemon that the handlers use.
struct Services {
  const Config& config;  ///< configuration at the daemon's start
  Settings& settings;
  Leases& leases;
  CameraActor& camera;
  CameraFinder& finder;
  SensorKeeper& keeper;
  Jobs& jobs;
  Procedures& procedures;
  Presentations& presentations;
  FrameGrabs& grabs;
  const Library& library;
  NamedReferences& named;
  PreparedLattices& lattices;
  ClosedLoop& loop;
  LiveRefiner& refiner;
  Recorder& recorder;
  Corrector& corrector;
  StatusReporter& status;
  SlmLoop& slm;
  Counters& counters;
  ClientGuard& clients;
  Disk& disk;
};

/// Converts an error to a JSON-RPC failure.
inline RpcAnswer failed(const Error& error) {
  return tl::make_unexpected(rpc_failure(error));
}

/// Reply to one JSON-RPC call: call it exactly once, from any thread, with an R or an error. All
/// copies reply to the same call, and share its lease, which ends before the client gets the reply.
template <class R>
class Reply {
 public:
  explicit Reply(RpcReply reply, LeasePtr lease = nullptr)
      : reply_(std::move(reply)), held_(std::make_shared<Held>()) {
    held_->lease = std::move(lease);
  }
  void operator()(const R& result) const { send(RpcResult{to_json(result)}); }
  /// Replies with a binary frame after the JSON.
  void operator()(const R& result, std::shared_ptr<const std::string> binary) const {
    send(RpcResult{to_json(result), std::move(binary)});
  }
  /// Replies with JSON that already has the fields of R.
  void operator()(JsonOf<R> result) const { send(RpcResult{std::move(result.json)}); }
  void operator()(const Error& error) const { send(failed(error)); }
  template <class Value>
  void operator()(const Result<Value>& result) const {
    if (!result) return (*this)(result.error());
    (*this)(*result);
  }
  /// Calls `then` when the lease of the call has begun, see Lease::begin.
  void begin_lease(std::function<void()> then) const { held_->lease->begin(std::move(then)); }
  /// The lease of the call, which now ends with what takes it. Once.
  LeasePtr take_lease() const {
    const std::scoped_lock lock(held_->mutex);
    return std::exchange(held_->lease, nullptr);
  }
  /// A reply to the same call with this lease.
  Reply with(LeasePtr lease) const { return Reply(reply_, std::move(lease)); }
  /// Ends the lease before the reply, when all that it was for is done.
  void end_lease() const {
    const std::scoped_lock lock(held_->mutex);
    held_->lease.reset();
  }

 private:
  void send(RpcAnswer answer) const {
    end_lease();
    reply_(std::move(answer));
  }

  /// A reply may end the lease in one thread while the method ends it in another.
  struct Held {
    std::mutex mutex;
    LeasePtr lease;
  };

  RpcReply reply_;
  std::shared_ptr<Held> held_;
};

struct MethodRow {
  const char* name;
  Role role;  ///< minimum role of the client
  Request request;
  /// Decodes the params, takes the lease of the request, and calls the handler.
  void (*call)(const MethodRow& row, Services& services, RpcCall call, RpcReply reply);
};

/// Makes the row of a method in proto/methods.hpp. The handler is `answer(services, params,
/// Reply<R>)`, or `answer(services, Reply<R>)` for a method without params, or `answer(services,
/// params, binary, Reply<R>)` for a method with a binary frame. It runs in the control thread and
/// must not block; it may reply later.
template <const auto& method, auto answer>
constexpr MethodRow row(Role role, Request request) {
  using M = std::remove_cvref_t<decltype(method)>;
  using P = typename M::Params;
  return {method.name, role, request,
          [](const MethodRow& row, Services& services, RpcCall call, RpcReply reply) {
            const auto decoded = decode_params<P>(call.params);
            if (!decoded) return reply(failed(decoded.error()));
            if (method.binary_params == nullptr && !call.binary.empty()) {
              return reply(failed({Errc::invalid, "", "this method takes no binary frame"}));
            }
            auto lease = services.leases.take(row.request);
            if (!lease) return reply(failed(lease.error()));
            const Reply<typename M::Result> typed(std::move(reply), std::move(*lease));
            if constexpr (method.binary_params != nullptr) {
              answer(services, *decoded, std::move(call.binary), typed);
            } else if constexpr (std::is_same_v<P, Nothing>) {
              answer(services, typed);
            } else {
              answer(services, *decoded, typed);
            }
          }};
}

// Method rows: of the camera, of an external corrector, of the sensor, of prepared lattices, of
// references, and all others. Add a method as a function and a row.
std::span<const MethodRow> camera_methods();
std::span<const MethodRow> corrector_methods();
std::span<const MethodRow> sensor_methods();
std::span<const MethodRow> lattice_methods();
std::span<const MethodRow> reference_methods();
std::span<const MethodRow> system_methods();

/// Calls a method for a client. Checks the client's key (empty without `security`) and role, then
/// the params, then what the request needs, so that a typo is reported even if the call is refused
/// now. The error for an unknown method names the nearest known method.
void dispatch(Services& services, const std::string& key, RpcCall call, RpcReply reply);
/// Names of all methods with the minimum role of each.
std::vector<std::pair<std::string, Role>> method_roles();

}  // namespace ovws
