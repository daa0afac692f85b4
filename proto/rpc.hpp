/// JSON-RPC 2.0 over one frame: from bytes to calls, from results to bytes. No sockets here.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

using Json = nlohmann::json;

constexpr std::size_t kMaxRequestBytes = 64 << 10;

/// The standard codes, and the daemon's own from -32000 on (one per Errc, and `forbidden`).
enum class RpcCode : int {
  parse = -32700,
  request = -32600,
  method = -32601,
  params = -32602,
  internal = -32603,
  refused = -32000,
  unavailable = -32001,
  device = -32002,
  forbidden = -32003,  ///< this client may not
};
RpcCode rpc_code(Errc code);

/// An answer to a method: its result, or an Error. `data` of the error reply is {field, reason,
/// …extra}.
struct RpcFailure {
  RpcCode code = RpcCode::internal;
  std::string message;
  Json data = Json::object();
};
RpcFailure rpc_failure(const Error& error);
using RpcAnswer = tl::expected<Json, RpcFailure>;

/// Called exactly once, from any thread.
using RpcReply = std::function<void(RpcAnswer)>;
/// What the daemon does with one call. The call is well-formed; `params` is an object (empty if
/// none was sent).
using RpcDispatch =
    std::function<void(const std::string& method, const Json& params, RpcReply reply)>;
/// Receives the one reply frame of a request frame, from any thread; empty if the frame held
/// notifications only.
using RpcSend = std::function<void(std::string)>;

constexpr int kMaxRequestDepth = 32;   ///< of nested objects and arrays
constexpr int kMaxBatchMembers = 100;  ///< more are refused with one error
/// A batch's member that comes when its reply is this large is refused, and not carried out.
constexpr std::size_t kMaxBatchReplyBytes = 1 << 20;

/// The reply to a request that is larger than kMaxRequestBytes or came in several frames; nobody
/// has to read it for that.
std::string oversize_reply();
/// The reply to a request that is refused unread, because too many of its client's requests wait.
std::string overload_reply();

/// Handles one request frame, single or batch: strict UTF-8 and JSON, size cap, JSON-RPC shape;
/// every member with an id gets exactly one response. Never throws, whatever the bytes are. A
/// dispatcher that throws, or that lets go of its reply without calling it, becomes an internal
/// error; a second call of a reply does nothing. `params` and `method` are borrowed for the call.
void handle_rpc_frame(std::string_view bytes, const RpcDispatch& dispatch, RpcSend send);

}  // namespace ovws
