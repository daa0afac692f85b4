/// GigE Vision control protocol (GVCP), read-only part: discovery and register reads.
#include "drivers/aravis/gige_probe.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <span>

#include "core/base/printable.hpp"
#include "drivers/aravis/udp_socket.hpp"

namespace ovws {

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint16_t kPort = 3956;
constexpr std::uint16_t kDiscovery = 0x0002, kReadRegister = 0x0080;  // acknowledge: command + 1
constexpr std::uint16_t kAccessDenied = 0x8006;
constexpr std::size_t kHeaderBytes = 8;

// GigE Vision bootstrap registers and the bits used in them.
constexpr std::uint32_t kLinkSpeed = 0x0670, kPacketSize = 0x0d04;
constexpr std::uint32_t kPacketSizeBits = 0xffff;
// Byte offsets of the texts in a discovery acknowledge, and its length.
constexpr std::size_t kVendor = 0x48, kModel = 0x68, kSerial = 0xd8, kDiscoveryBytes = 0xf8;

struct Answer {
  std::uint16_t status = 0;
  std::array<std::uint8_t, 1024> bytes{};
  std::size_t count = 0;
  Bytes payload() const { return Bytes(bytes).subspan(kHeaderBytes, count - kHeaderBytes); }
};

std::uint16_t number16(Bytes bytes) {
  return std::uint16_t(bytes[0] << 8 | bytes[1]);
}

std::uint32_t number32(Bytes bytes) {
  return std::uint32_t(number16(bytes)) << 16 | number16(bytes.subspan(2));
}

std::string text_at(Bytes bytes, std::size_t at, std::size_t longest) {
  const Bytes text = bytes.subspan(at, longest);
  return printable(std::string(text.begin(), std::ranges::find(text, 0)), kMaxNameBytes);
}

/// GVCP client for one camera.
class Gvcp {
 public:
  bool connect(const in_addr& address) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(kPort);
    to.sin_addr = address;
    return ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }

  /// Sends a command and waits for its acknowledge, up to three times. None: no answer.
  std::optional<Answer> ask(std::uint16_t command, Bytes payload) {
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
      if (!send(command, payload)) continue;
      if (auto answer = receive(std::uint16_t(command + 1))) return answer;
    }
    return std::nullopt;
  }

  /// Reads a register. None: no answer (`status` 0), or the camera refused (GVCP `status`).
  std::optional<std::uint32_t> read(std::uint32_t address, std::uint16_t& status) {
    const std::array<std::uint8_t, 4> payload{std::uint8_t(address >> 24),
                                              std::uint8_t(address >> 16),
                                              std::uint8_t(address >> 8), std::uint8_t(address)};
    const auto answer = ask(kReadRegister, payload);
    status = answer ? answer->status : 0;
    if (!answer || answer->status != 0 || answer->payload().size() < 4) return std::nullopt;
    return number32(answer->payload());
  }

 private:
  bool send(std::uint16_t command, Bytes payload) {
    constexpr std::uint8_t kKey = 0x42, kAckRequired = 0x01;
    if (++id_ == 0) ++id_;  // request id 0 is invalid in GVCP
    std::array<std::uint8_t, kHeaderBytes + 4> packet{kKey,
                                                      kAckRequired,
                                                      std::uint8_t(command >> 8),
                                                      std::uint8_t(command),
                                                      0,
                                                      std::uint8_t(payload.size()),
                                                      std::uint8_t(id_ >> 8),
                                                      std::uint8_t(id_)};
    std::ranges::copy(payload, packet.begin() + kHeaderBytes);
    const std::size_t size = kHeaderBytes + payload.size();
    return ::send(socket_.get(), packet.data(), size, 0) == ssize_t(size);
  }

  std::optional<Answer> receive(std::uint16_t wanted) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::milliseconds(350);
    while (true) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
      pollfd waiting{socket_.get(), POLLIN, 0};
      if (left <= 0 || ::poll(&waiting, 1, int(left)) <= 0) return std::nullopt;
      Answer answer;
      const ssize_t count = ::recv(socket_.get(), answer.bytes.data(), answer.bytes.size(), 0);
      if (count < ssize_t(kHeaderBytes)) {
        if (count < 0) return std::nullopt;  // ICMP error: no program listens on the port
        continue;
      }
      answer.count = std::size_t(count);
      answer.status = number16(answer.bytes);
      const Bytes header(answer.bytes);
      if (number16(header.subspan(2)) == wanted && number16(header.subspan(6)) == id_)
        return answer;
    }
  }

  UdpSocket socket_;
  std::uint16_t id_ = 0;
};

}  // namespace

Result<GigeAnswer> ask_gige_camera(const std::string& address) {
  in_addr numeric{};
  if (::inet_pton(AF_INET, address.c_str(), &numeric) != 1)
    return fail(Errc::invalid, "camera.id", address + " is not an IPv4 address");
  Gvcp gvcp;
  const auto found = gvcp.connect(numeric) ? gvcp.ask(kDiscovery, {}) : std::nullopt;
  if (!found || found->status != 0 || found->payload().size() < kDiscoveryBytes)
    return fail(Errc::unavailable, "camera.id",
                "no camera answers at " + address + "; check its cable, power and address");
  GigeAnswer answer;
  answer.vendor = text_at(found->payload(), kVendor, 32);
  answer.model = text_at(found->payload(), kModel, 32);
  answer.serial = text_at(found->payload(), kSerial, 16);
  std::uint16_t status = 0;
  const auto control = gvcp.read(kControlRegister, status);
  // Under exclusive access the camera denies reads to all other programs.
  answer.controlled = control ? (*control & kControlBits) != 0 : status == kAccessDenied;
  const auto size = gvcp.read(kPacketSize, status);
  if (size && (*size & kPacketSizeBits) != 0) answer.packet_size_bytes = *size & kPacketSizeBits;
  const auto speed = gvcp.read(kLinkSpeed, status);
  constexpr std::uint32_t kMaxMbps = 1'000'000;  // larger values are no link speed
  if (speed && *speed > 0 && *speed <= kMaxMbps) answer.link_mbps = int(*speed);
  return answer;
}

}  // namespace ovws
