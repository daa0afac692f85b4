/// What the twin's camera says of itself: its GenICam description and the registers behind it.
#pragma once

#include <cstdint>
#include <string_view>

namespace ovws::twin {

/// Registers of our own, in the memory that Aravis's fake camera does not use.
constexpr std::uint32_t kRegisterWantedPeriodUs = 0x400;

constexpr double kGainStepDb = 0.1;  ///< the gain register counts these
constexpr double kMaxGainDb = 48.0;

constexpr char kVendorName[] = "ovws";
constexpr char kModelName[] = "Bench twin";

/// GenICam XML. Standard names (SFNC): Width, Height, OffsetX, OffsetY, PixelFormat (all
/// that are known), ExposureTime, Gain (dB), AcquisitionFrameRate, AcquisitionStart, …; the
/// registers are those of Aravis's fake camera, so that it streams by them.
std::string_view genicam_xml();

}  // namespace ovws::twin
