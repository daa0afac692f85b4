#include "daemon/examine/machine/machine.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "core/base/printable.hpp"
#include "daemon/shared/shell_word.hpp"

namespace ovws::examine {
namespace {

/// Finds the camera that camera.id names. First queries camera.id as an address. Without an answer,
/// looks it up in the camera list by address or name, and queries a GigE camera found in the list.
void find_camera(CameraFacts& facts) {
  const std::string& id = facts.config.id;
  const auto answer = ask_gige_camera(id);
  if (answer) {
    facts.answer = *answer;
    facts.camera = ListedCamera{answer->vendor + " " + answer->model, answer->serial, id, true};
    return;
  }
  facts.listed = list_cameras();
  const bool by_address = answer.error().code != Errc::invalid;
  if (by_address) {
    const auto heard = std::ranges::find(facts.listed, id, &ListedCamera::address);
    if (heard != facts.listed.end()) facts.camera = *heard;
    return;
  }
  if (const ListedCamera* const named = find_listed(facts.listed, id)) {
    facts.camera = *named;
    if (!named->gige) return;
    if (const auto asked = ask_gige_camera(named->address)) facts.answer = *asked;
  }
}

constexpr const char* kNoCamera = "the camera does not answer";
constexpr const char* kUsb = "the camera is on USB";

bool on_usb(const CameraFacts& facts) {
  return facts.camera && !facts.camera->gige;
}

double frame_bytes(const CameraSettings& settings) {
  return double(row_bytes(settings.pixel_format, settings.roi.width)) * settings.roi.height;
}

/// Suggests an address for this machine in the camera's /24 network.
std::string add_address_near(const std::string& address) {
  const std::string network = address.substr(0, address.rfind('.') + 1);
  return fmt::format("sudo ip address add {}{}/24 dev INTERFACE", network,
                     address == network + "1" ? 2 : 1);
}

Finding judge_found(const CameraFacts& facts) {
  if (facts.answer || on_usb(facts)) {
    return good(facts.camera->id + " answers" +
                (facts.camera->address.empty() ? "" : " at " + facts.camera->address));
  }
  if (facts.camera) {
    return bad(
        fmt::format("discovery finds {}, but it does not answer at its address {}: give this "
                    "machine an address in the camera's network",
                    facts.camera->id, facts.camera->address),
        add_address_near(facts.camera->address));
  }
  if (facts.listed.empty()) {
    return bad("camera.id is " + facts.config.id +
                   ", but no camera at all is found: check its cable and power, then list the "
                   "cameras",
               "arv-tool-0.8");
  }
  const ListedCamera& other = facts.listed.front();
  return bad("camera.id is " + facts.config.id +
                 ", but other cameras were found: " + names_of(facts.listed),
             fmt::format("\"camera\": {{\"id\": \"{}\"}}",
                         printable(other.gige && !other.address.empty() ? other.address : other.id,
                                   kMaxNameBytes)));
}

Finding judge_control(const CameraFacts& facts) {
  if (on_usb(facts)) return not_here("a USB camera does not report which program controls it");
  if (!facts.answer) return not_here(kNoCamera);
  if (!facts.answer->controlled)
    return good("no program controls the camera: a daemon can take control");
  if (facts.daemon == DaemonsCamera::with) return good("the daemon controls the camera");
  const std::string fix = "sudo ss --udp --all --processes";
  if (facts.daemon == DaemonsCamera::silent) {
    return warning(
        "a program controls the camera, but no daemon answers here: close that program "
        "before you start a daemon; the command lists candidates",
        fix);
  }
  return bad(
      "a program other than the daemon controls the camera, possibly on another machine: "
      "close it; the command lists candidates on this machine",
      fix);
}

Finding judge_interface(const CameraFacts& facts) {
  if (on_usb(facts)) return not_here(kUsb);
  const std::string address = facts.camera ? facts.camera->address : facts.config.id;
  if (!facts.path) {
    if (!facts.camera && !facts.listed.empty()) return not_here(kNoCamera);
    const bool numeric = address.find_first_not_of("0123456789.") == std::string::npos;
    if (!numeric) return not_here(kNoCamera);
    return bad("no network interface of this machine leads to " + address,
               add_address_near(address));
  }
  const std::string where =
      fmt::format("{} ({}) leads to {}", facts.path->interface, facts.path->own_address, address);
  if (facts.path->same_network) return good(where);
  return warning(where +
                     " through a router, which may lose packets and blocks large ones: give this "
                     "machine an address in the camera's network",
                 add_address_near(address));
}

/// Link speed, Mbit/s: the slowest speed reported along the path to the camera; none: unknown.
std::optional<int> link_mbps(const CameraFacts& facts) {
  std::optional<int> slowest;
  for (const auto& one : {facts.usb_mbps, facts.answer ? facts.answer->link_mbps : std::nullopt,
                          facts.path ? facts.path->link_mbps : std::nullopt}) {
    if (one) slowest = std::min(*one, slowest.value_or(*one));
  }
  return slowest;
}

Finding judge_link(const CameraFacts& facts) {
  constexpr double kOverhead = 1.05;  // factor for headers and retransmitted packets
  if (!facts.camera) return not_here(kNoCamera);
  const auto link = link_mbps(facts);
  if (!link) return not_here("neither the camera nor its interface reports a link speed");
  const CameraSettings& settings = facts.config.settings;
  const double needed_mbps =
      8e-6 * kOverhead * frame_bytes(settings) * std::max(settings.frame_rate_hz, 0.0);
  const std::string says = fmt::format("the configured frames need {:.0f} Mbit/s, the link has {}",
                                       std::ceil(needed_mbps), *link);
  if (needed_mbps <= *link) return good(says);
  const double rate_hz = settings.frame_rate_hz * *link / needed_mbps;
  return bad(
      says + ": frames will be lost; lower the frame rate, or repair the cable, port or switch",
      fmt::format("\"camera\": {{\"frame_rate_hz\": {:.3g}}}",
                  rate_hz >= 1.0 ? std::floor(rate_hz) : 0.9 * rate_hz));
}

Finding judge_packets(const CameraFacts& facts) {
  if (on_usb(facts)) return not_here(kUsb);
  if (!facts.path || facts.path->mtu_bytes == 0) {
    return not_here("the network interface to the camera is unknown");
  }
  const int mtu = facts.path->mtu_bytes;
  const int asked = facts.config.packet_size_bytes;
  const bool in_use =
      facts.answer && facts.answer->controlled && facts.answer->packet_size_bytes.has_value();
  const int sent = in_use ? *facts.answer->packet_size_bytes : asked;
  const std::string fix = fmt::format("sudo ip link set dev {} mtu {}",
                                      shell_word(facts.path->interface), std::max(asked, sent));
  const std::string takes =
      fmt::format("{} accepts packets of up to {} bytes", facts.path->interface, mtu);
  if (in_use && sent > mtu) {
    return bad(fmt::format("the camera sends packets of {} bytes, but {}", sent, takes), fix);
  }
  if (asked > mtu) {
    return warning(fmt::format("camera.packet_size_bytes is {}, but {}: no frame arrives unless "
                               "Aravis falls back to a smaller packet size",
                               asked, takes),
                   fix);
  }
  return good(fmt::format("camera.packet_size_bytes is {}, and {}", asked, takes));
}

Finding judge_socket_buffer(const CameraFacts& facts) {
  if (on_usb(facts)) return not_here(kUsb);
  if (!facts.rmem_max_bytes) return not_here("net.core.rmem_max cannot be read here");
  const std::string says = fmt::format("net.core.rmem_max is {}, a daemon requests {} bytes",
                                       *facts.rmem_max_bytes, facts.socket_buffer_bytes);
  if (*facts.rmem_max_bytes >= facts.socket_buffer_bytes) return good(says);
  return warning(says +
                     ": frames come up to 5 ms late, through a packet socket; or, to a daemon "
                     "without CAP_NET_RAW, with lost packets when the CPU is busy",
                 fmt::format("sudo sysctl -w net.core.rmem_max={}", facts.socket_buffer_bytes));
}

Finding judge_usb_memory(const CameraFacts& facts) {
  constexpr const char* kPath = "/sys/module/usbcore/parameters/usbfs_memory_mb";
  if (!facts.camera) return not_here(kNoCamera);
  if (!on_usb(facts)) return not_here("the camera is on the network");
  if (!facts.usbfs_mb) return not_here("usbfs_memory_mb cannot be read here");
  const auto needed_mb =
      std::int64_t(std::ceil(frame_bytes(facts.config.settings) * facts.buffers / 1048576.0)) + 1;
  const std::string says = fmt::format(
      "the kernel allows {} MiB for USB transfers, {} buffers of the configured frames "
      "need {}",
      *facts.usbfs_mb, facts.buffers, needed_mb);
  if (*facts.usbfs_mb == 0) return good("the kernel does not limit the memory of USB transfers");
  if (*facts.usbfs_mb >= needed_mb) return good(says);
  return bad(says + ": frames will be lost",
             fmt::format("echo {} | sudo tee {}", std::max<std::int64_t>(needed_mb, 1000), kPath));
}

}  // namespace

CameraFacts read_camera(const CameraConfig& config, DaemonsCamera daemon) {
  CameraFacts facts;
  facts.config = config;
  facts.daemon = daemon;
  find_camera(facts);
  if (facts.camera && !facts.camera->gige) {
    facts.usb_mbps = usb_link_mbps(facts.camera->serial);
  } else if (const auto path = path_to(facts.camera ? facts.camera->address : config.id)) {
    facts.path = *path;
  }
  facts.usbfs_mb = number_of("/sys/module/usbcore/parameters/usbfs_memory_mb");
  facts.rmem_max_bytes = number_of("/proc/sys/net/core/rmem_max");
  return facts;
}

Findings answers(const CameraFacts& facts) {
  constexpr Question<CameraFacts> kQuestions[] = {
      {"camera.found", judge_found, kLater},  // by the step camera
      {"camera.control", judge_control},
      {"camera.interface", judge_interface},
      {"camera.link", judge_link},
      {"camera.packets", judge_packets},
      {"camera.socket_buffer", judge_socket_buffer},
      {"camera.usb_memory", judge_usb_memory},
  };
  return answers<CameraFacts>(kQuestions, facts);
}

}  // namespace ovws::examine
