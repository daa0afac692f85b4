/// JSON-RPC 2.0 codec: one request frame to calls, their results to one reply frame. No sockets
/// here.
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

/// Error codes of JSON-RPC 2.0: the standard codes, and the daemon's own from -32000 downwards.
/// rpc_code maps each Errc to a code; `forbidden` has no Errc.
enum class RpcCode : int {
  parse = -32700,
  request = -32600,
  method = -32601,
  params = -32602,
  internal = -32603,
  refused = -32000,
  unavailable = -32001,
  device = -32002,
  forbidden = -32003,  ///< the client is not permitted to call the method
};
RpcCode rpc_code(Errc code);

/// Error in a JSON-RPC reply. `data` holds `field` and `reason`, and where applicable `min`, `max`
/// and `nearest`.
struct RpcFailure {
  RpcCode code = RpcCode::internal;
  std::string message;
  Json data = Json::object();
};
RpcFailure rpc_failure(const Error& error);
/// Result of a call: JSON, and the bytes of the binary frame that follows it; null: none.
struct RpcResult {
  Json json;
  std::shared_ptr<const std::string> binary;
  RpcResult(Json value) : json(std::move(value)) {}  // NOLINT: a result is usually JSON alone
  RpcResult(Json value, std::shared_ptr<const std::string> bytes)
      : json(std::move(value)), binary(std::move(bytes)) {}
};
using RpcAnswer = tl::expected<RpcResult, RpcFailure>;

/// Callback for the answer to one call. Call it exactly once, from any thread.
using RpcReply = std::function<void(RpcAnswer)>;
/// One well-formed call. `params` is an object (empty if none was sent); `binary` is the binary
/// frame of the request, empty if there was none.
struct RpcCall {
  const std::string& method;
  const Json& params;
  std::string binary;
};
using RpcDispatch = std::function<void(RpcCall call, RpcReply reply)>;
/// Callback that sends the reply to a request: its JSON, and its binary frame (null: none). It may
/// be called from any thread. The JSON is empty if the request held notifications only.
using RpcSend = std::function<void(std::string json, std::shared_ptr<const std::string> binary)>;

constexpr int kMaxRequestDepth = 32;   ///< nesting depth of objects and arrays
constexpr int kMaxBatchMembers = 100;  ///< a larger batch is refused with one error
/// Once a batch's reply has this size, further members are refused and not carried out.
constexpr std::size_t kMaxBatchReplyBytes = 1 << 20;

/// Reply to a request that is larger than kMaxRequestBytes, or whose binary frame is larger than
/// `max_binary_bytes` (0: there is no method with one), or that came in more frames. It does not
/// depend on the request's content.
std::string oversize_reply(std::size_t max_binary_bytes = 0);
/// Reply to a request that is refused unread because too many requests of its client are waiting.
std::string overload_reply();

/// Handles one request, single or batch: checks size, strict UTF-8 and JSON, and the JSON-RPC
/// envelope. A batch has no binary frames, neither in the request nor in results. Every member with
/// an id gets exactly one response. Never throws, whatever the bytes are. A dispatcher that throws,
/// or drops its reply without calling it, causes an internal error; a second call of a reply does
/// nothing. The call's `method` and `params` are valid only during the dispatcher's call.
void handle_rpc(std::string_view json, std::string binary, const RpcDispatch& dispatch,
                RpcSend send);

}  // namespace ovws
