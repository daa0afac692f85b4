/// Field tables of the devices that could be used: cameras that answer, outputs of the display.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/port/display.hpp"
#include "proto/field_json.hpp"

namespace ovws {

inline std::optional<std::string> no_device_name(const std::string& text) {
  constexpr std::size_t kMaxBytes = 200;
  if (text.empty()) return "must not be empty";
  return text.size() > kMaxBytes ? std::optional<std::string>("is too long") : std::nullopt;
}

/// A camera that answered the discovery.
struct CameraListing {
  std::string id, serial, address;
  bool gige = false;
  bool selected = false;
};
template <>
inline constexpr auto kTable<CameraListing> =
    Fields{"CameraListing",
           field<&CameraListing::id>("id for camera.select: vendor, model and serial number"),
           field<&CameraListing::serial>("serial number, or null").or_null(),
           field<&CameraListing::address>("network address or USB device, or null").or_null(),
           field<&CameraListing::gige>("whether it is a GigE Vision camera, otherwise USB3 Vision"),
           field<&CameraListing::selected>("whether the daemon uses or awaits this camera")};

/// Result of `camera.list`.
struct CameraList {
  std::vector<CameraListing> cameras;
};
template <>
inline constexpr auto kTable<CameraList> =
    Fields{"CameraList", field<&CameraList::cameras>("cameras that answer now")};

/// Params of `camera.select`.
struct CameraSelect {
  std::string id;
  bool wait = false;
};
template <>
inline constexpr auto kTable<CameraSelect> =
    Fields{"CameraSelect",
           field<&CameraSelect::id>("the camera's id or serial number as in camera.list, or its IP "
                                    "address")
               .checked(no_device_name)
               .mandatory(),
           field<&CameraSelect::wait>("true: also accept a camera that does not answer now, and "
                                      "connect when it does")};

template <>
inline constexpr auto kTable<DisplayOutput> = Fields{
    "DisplayOutput",
    field<&DisplayOutput::name>("name of the output, for slm.set"),
    field<&DisplayOutput::monitor>("name of the monitor or SLM, or null").or_null(),
    field<&DisplayOutput::connected>("whether something is connected"),
    field<&DisplayOutput::on>("whether it shows a part of the desktop"),
    field<&DisplayOutput::primary>("whether it is the desktop's primary output"),
    field<&DisplayOutput::width>("width, pixels; 0: off", Bounds::at_least(0)),
    field<&DisplayOutput::height>("height, pixels; 0: off", Bounds::at_least(0)),
    field<&DisplayOutput::refresh_hz>("refresh rate, Hz; 0: off or unknown", Bounds::at_least(0)),
    computed(
        "usable", [](auto& output) { return output.reason.empty(); },
        "whether it can be the SLM with the configured size and slm.allow_primary"),
    field<&DisplayOutput::reason>("why it cannot be the SLM, and what to do; null: it can")
        .or_null(),
    field<&DisplayOutput::selected>("whether slm.display names it")};

/// Result of `slm.outputs`.
struct OutputList {
  std::vector<DisplayOutput> outputs;
};
template <>
inline constexpr auto kTable<OutputList> =
    Fields{"OutputList", field<&OutputList::outputs>("all outputs, in the display system's order")};

template <>
inline constexpr auto kTable<SlmSettings> = Fields{
    "SlmSettings",
    field<&SlmSettings::display>("name of the output that drives the SLM, e.g. HDMI-1")
        .checked(no_device_name),
    field<&SlmSettings::allow_primary>("whether the only or primary output may drive the SLM"),
    field<&SlmSettings::settle_ms>("settle time after a new hologram, milliseconds",
                                   limits::kSettleMs)};
using SlmSet = Partial<SlmSettings>;

}  // namespace ovws
