#include "proto/rpc.hpp"

#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <utility>

#include "proto/json_text.hpp"
#include "proto/reader.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxIdBytes = 256;  // bounds the memory of queued replies

/// Builds a JSON-RPC response as text. Copying a large result into another JSON value would take as
/// long as its serialisation.
std::string response(const Json& id, const RpcAnswer& answer) {
  std::string text = R"({"jsonrpc":"2.0","id":)" + json_text(id);
  if (answer) return text + R"(,"result":)" + json_text(answer->json) + "}";
  const RpcFailure& failure = answer.error();
  const Json error{
      {"code", int(failure.code)}, {"message", failure.message}, {"data", failure.data}};
  return text + R"(,"error":)" + json_text(error) + "}";
}

RpcFailure failure(RpcCode code, std::string field, std::string reason) {
  RpcFailure out{code, field.empty() ? reason : field + ": " + reason, Json::object()};
  out.data = {{"field", std::move(field)}, {"reason", std::move(reason)}};
  return out;
}

RpcAnswer no_binary_in_batch() {
  return tl::make_unexpected(failure(RpcCode::refused, "",
                                     "a request or a result with a binary frame cannot be part of "
                                     "a batch: send the request alone"));
}

/// Collects the responses to one request frame from any thread and sends them after the last one.
class ReplyCollector {
 public:
  ReplyCollector(std::size_t members, bool batch, RpcSend send)
      : responses_(members), missing_(members), batch_(batch), send_(std::move(send)) {}

  /// Whether the responses of a batch have reached kMaxBatchReplyBytes.
  bool is_full() const {
    const std::lock_guard lock(mutex_);
    return batch_ && bytes_ >= kMaxBatchReplyBytes;
  }

  bool is_batch() const { return batch_; }

  /// Stores the response to member `k`; an empty text for a notification. Only the response to a
  /// single request may have a binary frame.
  void put(std::size_t k, std::string text, std::shared_ptr<const std::string> binary) {
    {
      const std::lock_guard lock(mutex_);
      bytes_ += text.size();
      responses_[k] = std::move(text);
      if (--missing_ > 0) return;
    }
    send_(joined(), std::move(binary));
  }

 private:
  std::string joined() {
    if (!batch_) return std::move(responses_[0]);
    std::string text;
    text.reserve(bytes_ + responses_.size() + 1);
    for (auto& one : responses_) {
      if (!one.empty()) text.append(text.empty() ? "[" : ",").append(one);
      one = {};
    }
    return text.empty() ? text : std::move(text.append("]"));
  }

  mutable std::mutex mutex_;
  std::vector<std::string> responses_;
  std::size_t bytes_ = 0;
  std::size_t missing_;
  bool batch_;
  RpcSend send_;
};

/// A pending call: one member of a request frame until it is answered. If destroyed without an
/// answer, it replies with an internal error.
class PendingCall {
 public:
  PendingCall(std::shared_ptr<ReplyCollector> collector, std::size_t k)
      : collector_(std::move(collector)), k_(k) {}
  PendingCall(const PendingCall&) = delete;
  PendingCall& operator=(const PendingCall&) = delete;
  ~PendingCall() {
    try {
      answer(
          tl::make_unexpected(failure(RpcCode::internal, "",
                                      "no answer was produced, perhaps because the daemon is "
                                      "stopping; check its state before repeating the request")));
    } catch (...) {  // out of memory: the error cannot be reported
    }
  }

  void set_request_id(Json id) { id_ = std::move(id); }
  void set_notification() { silent_ = true; }

  void answer(const RpcAnswer& answer) {
    if (answered_.exchange(true)) return;
    if (silent_) return collector_->put(k_, "", nullptr);
    if (answer && answer->binary && collector_->is_batch()) {
      return collector_->put(k_, response(id_, no_binary_in_batch()), nullptr);
    }
    collector_->put(k_, response(id_, answer), answer ? answer->binary : nullptr);
  }

  /// Whether the batch's reply has no room for this call's response. A notification has no
  /// response.
  bool lacks_room() const { return !silent_ && collector_->is_full(); }

 private:
  std::shared_ptr<ReplyCollector> collector_;
  std::size_t k_;
  Json id_;  // null until set_request_id
  bool silent_ = false;
  std::atomic<bool> answered_{false};
};

/// Whether a JSON-RPC id can be echoed unchanged. Integers beyond 64 bits cannot, because the
/// parser turns them into doubles.
bool is_valid_id(const Json& id) {
  constexpr double kPastInt64 = 0x1p63;
  if (id.is_number_float()) return std::abs(id.get<double>()) < kPastInt64;
  if (id.is_string()) return id.get_ref<const std::string&>().size() <= kMaxIdBytes;
  return id.is_number() || id.is_null();
}

/// Reads the JSON-RPC envelope of one call. A valid id is echoed even if the rest is invalid.
Result<std::string> read_envelope(const Json& member, PendingCall& call) {
  ObjectReader reader(member, "");
  const Json* id = reader.raw("id");
  const bool id_is_valid = id != nullptr && is_valid_id(*id);
  if (id_is_valid) call.set_request_id(*id);
  if (id != nullptr && !id_is_valid)
    reader.fault("id",
                 "must be an integer of at most 64 bits, a fraction below 2^63, null, or a string "
                 "of at most 256 bytes");
  std::string version, method;
  reader.require("jsonrpc");
  reader.string("jsonrpc", version);
  if (version != "2.0") reader.fault("jsonrpc", "must be \"2.0\"");
  reader.require("method");
  reader.string("method", method);
  reader.raw("params");
  if (auto done = reader.finish(); !done) return fail(done.error());
  if (id == nullptr) call.set_notification();
  return method;
}

void run_call(const Json& member, std::string binary, const std::shared_ptr<PendingCall>& call,
              const RpcDispatch& dispatch) {
  const auto method = read_envelope(member, *call);
  if (!method) {
    auto refusal = rpc_failure(method.error());
    refusal.code = RpcCode::request;
    return call->answer(tl::make_unexpected(std::move(refusal)));
  }
  if (call->lacks_room()) {
    return call->answer(tl::make_unexpected(failure(
        RpcCode::refused, "",
        "the batch's reply would be larger than " + std::to_string(kMaxBatchReplyBytes >> 20) +
            " MiB; this request was not carried out; send it in another batch")));
  }
  static const Json kNoParams = Json::object();
  const auto params = member.find("params");
  if (params != member.end() && !params->is_object()) {
    return call->answer(tl::make_unexpected(
        failure(RpcCode::params, "params",
                params->is_array()
                    ? "must be an object with named keys; values by position are not accepted"
                    : "must be an object, or left out")));
  }
  try {
    dispatch({*method, params == member.end() ? kNoParams : *params, std::move(binary)},
             [call](const RpcAnswer& answer) { call->answer(answer); });
  } catch (const std::exception& error) {
    call->answer(tl::make_unexpected(
        failure(RpcCode::internal, "", std::string("internal error: ") + error.what())));
  } catch (...) {
    call->answer(tl::make_unexpected(failure(RpcCode::internal, "", "internal error")));
  }
}

std::string error_frame(RpcCode code, std::string reason) {
  return response(nullptr, tl::make_unexpected(failure(code, "", std::move(reason))));
}

}  // namespace

RpcCode rpc_code(Errc code) {
  constexpr std::array kCodes{RpcCode::params, RpcCode::refused, RpcCode::unavailable,
                              RpcCode::device, RpcCode::internal};  // in the order of Errc
  return kCodes[std::size_t(code)];
}

RpcFailure rpc_failure(const Error& error) {
  auto out = failure(rpc_code(error.code), error.field, error.reason);
  if (error.min) out.data["min"] = *error.min;
  if (error.max) out.data["max"] = *error.max;
  if (!error.nearest.empty()) out.data["nearest"] = error.nearest;
  return out;
}

std::string overload_reply() {
  return error_frame(RpcCode::refused,
                     "too many requests of this client are waiting; this request was not carried "
                     "out; read replies before sending more");
}

std::string oversize_reply(std::size_t max_binary_bytes) {
  std::string reason =
      "a request must be one frame of at most " + std::to_string(kMaxRequestBytes) + " bytes";
  if (max_binary_bytes > 0) {
    reason += ", followed, for a method that takes one, by a binary frame of at most " +
              std::to_string(max_binary_bytes) + " bytes";
  }
  return error_frame(RpcCode::request, std::move(reason));
}

void handle_rpc(std::string_view bytes, std::string binary, const RpcDispatch& dispatch,
                RpcSend send) {
  const auto refuse = [&send](RpcCode code, std::string reason) {
    send(error_frame(code, std::move(reason)), nullptr);
  };
  if (bytes.size() > kMaxRequestBytes) return send(oversize_reply(), nullptr);
  const auto request = parse_strict_json(bytes, kMaxRequestDepth, JsonComments::refused);
  if (!request) {
    return refuse(request.error().malformed ? RpcCode::parse : RpcCode::request,
                  request.error().reason);
  }
  if (!request->is_array()) {
    auto collector = std::make_shared<ReplyCollector>(1, false, std::move(send));
    return run_call(*request, std::move(binary),
                    std::make_shared<PendingCall>(std::move(collector), 0), dispatch);
  }
  if (!binary.empty()) return refuse(RpcCode::request, no_binary_in_batch().error().message);
  if (request->empty()) return refuse(RpcCode::request, "a batch must hold at least one request");
  if (request->size() > kMaxBatchMembers) {
    return refuse(RpcCode::request,
                  "a batch may hold at most " + std::to_string(kMaxBatchMembers) + " requests");
  }
  auto collector = std::make_shared<ReplyCollector>(request->size(), true, std::move(send));
  for (std::size_t k = 0; k < request->size(); ++k) {
    run_call((*request)[k], {}, std::make_shared<PendingCall>(collector, k), dispatch);
  }
}

}  // namespace ovws
