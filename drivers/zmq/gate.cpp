#include "drivers/zmq/gate.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <zmq_addon.hpp>

#include "drivers/zmq/curve.hpp"
#include "drivers/zmq/gate_parts.hpp"

namespace ovws {
namespace {

constexpr const char* kZapEndpoint = "inproc://zeromq.zap.01";
constexpr const char* kRejectDomain = "ends";  // ZAP domain: how unknown keys are treated
constexpr const char* kRetryDomain = "comes again";
constexpr int kIoThreads = 3;  // one per socket, so that encrypting images delays no measurement
constexpr int kMaxAnswersPerTurn = 64;
constexpr int kHandshakeMs = 5000;  // a client refused with 300 stays in its handshake this long
/// Monitor events of handshakes that fail before the ZAP request. A client without a key may
/// disconnect when it sees that CURVE is required; libzmq reports this as ..._NO_DETAIL.
constexpr int kEvents = ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
constexpr std::size_t kZapFrames = 7;  // of a ZAP request with CURVE, exactly
constexpr std::size_t kCurveKeyBytes = 32;

using Frames = std::vector<zmq::message_t>;

/// The next multipart message; empty if none is waiting.
Frames receive(zmq::socket_t& socket) {
  Frames frames;
  (void)zmq::recv_multipart(socket, std::back_inserter(frames), zmq::recv_flags::dontwait);
  return frames;
}

/// Client key (Z85) of a ZAP request: [version, request, domain, address, routing id, mechanism,
/// key].
std::string key_of(const Frames& frames) {
  if (frames.size() != kZapFrames || frames[5].to_string_view() != "CURVE") return {};
  if (frames[6].size() != kCurveKeyBytes) return {};
  std::array<char, 41> text{};
  zmq_z85_encode(text.data(), frames[6].data<std::uint8_t>(), kCurveKeyBytes);
  return text.data();
}

std::string handshake_fault(std::uint16_t event, std::uint32_t value) {
  if (event == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL) {
    return "a connection ended in the handshake, which happens for clients without a key";
  }
  switch (value) {
    case ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH:
      return "a client tried to connect without a key";
    case ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC:
      return "a client used another server key, or replayed the messages of another client";
    default:
      return "a client violated the handshake protocol";
  }
}

}  // namespace

Result<std::unique_ptr<Gate>> Gate::make(const std::string& secret_key, GateCalls calls) {
  if (!public_key_of(secret_key)) {
    return fail(Errc::invalid, "security.secret_key", "is not a key: make one with ovws keygen");
  }
  auto parts = make_hidden<Parts>();
  parts->context = std::make_shared<zmq::context_t>(kIoThreads);
  parts->secret_key = secret_key;
  parts->calls = std::move(calls);
  parts->zap = zmq::socket_t(*parts->context, zmq::socket_type::rep);
  parts->zap.set(zmq::sockopt::linger, 0);
  parts->zap.bind(kZapEndpoint);
  return std::unique_ptr<Gate>(new Gate(std::move(parts)));
}

void Gate::end_streams() {
  parts_->generation.fetch_add(1);
}

void Gate::Parts::guard(zmq::socket_t& socket, UnknownKey unknown_key) {
  const std::size_t k = monitors.size();
  socket.set(zmq::sockopt::affinity, std::uint64_t(1) << (k % kIoThreads));
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey, secret_key);
  socket.set(zmq::sockopt::handshake_ivl, kHandshakeMs);
  socket.set(zmq::sockopt::zap_domain,
             unknown_key == UnknownKey::reject ? kRejectDomain : kRetryDomain);
  const std::string endpoint = "inproc://gate-" + std::to_string(k);
  zmq_socket_monitor(socket.handle(), endpoint.c_str(), kEvents);
  monitors.emplace_back(*context, zmq::socket_type::pair);
  monitors.back().set(zmq::sockopt::linger, 0);
  monitors.back().connect(endpoint);
}

void Gate::Parts::add_to(std::vector<zmq_pollitem_t>& items) {
  items.push_back({zap.handle(), 0, ZMQ_POLLIN, 0});
  for (auto& monitor : monitors) items.push_back({monitor.handle(), 0, ZMQ_POLLIN, 0});
}

void Gate::Parts::serve() {
  for (int k = 0; k < kMaxAnswersPerTurn && answer_one(); ++k) {
  }
  for (auto& monitor : monitors) {
    for (int k = 0; k < kMaxAnswersPerTurn && note_one(monitor, calls); ++k) {
    }
  }
}

bool Gate::Parts::answer_one() {
  const Frames request = receive(zap);
  if (request.empty()) return false;
  const std::string key = key_of(request);
  const bool known = !key.empty() && calls.knows(key);
  if (!known) {
    const std::string address = request.size() > 3 ? request[3].to_string() : "";
    calls.rejected("the key " + key + (address.empty() ? "" : " at " + address) +
                   " is not among the clients");
  }
  const std::string number = request.size() > 1 ? request[1].to_string() : "";
  const bool reject = request.size() > 2 && request[2].to_string_view() == kRejectDomain;
  const char* const refusal = reject ? "400" : "300";
  const std::array<std::string, 6> reply{
      "1.0", number, known ? "200" : refusal, known ? "OK" : "unknown key", known ? key : "", ""};
  std::vector<zmq::const_buffer> frames;
  for (const std::string& text : reply) frames.push_back(zmq::buffer(text));
  (void)zmq::send_multipart(zap, frames, zmq::send_flags::dontwait);
  return true;
}

bool Gate::Parts::note_one(zmq::socket_t& monitor, const GateCalls& calls) {
  const Frames event = receive(monitor);
  if (event.empty()) return false;
  constexpr std::size_t kEventBytes = 6;  // uint16 event, uint32 value
  if (event[0].size() != kEventBytes) return true;
  std::uint16_t kind = 0;
  std::uint32_t value = 0;
  std::memcpy(&kind, event[0].data<char>(), sizeof kind);
  std::memcpy(&value, event[0].data<char>() + sizeof kind, sizeof value);
  const std::string at = event.size() > 1 ? " at " + event[1].to_string() : "";
  calls.rejected(handshake_fault(kind, value) + at);
  return true;
}

}  // namespace ovws
