/// GenICam description of the twin's camera, and its own registers.
#pragma once

#include <cstdint>
#include <string_view>

namespace ovws::twin {

/// Registers of our own, in the memory that Aravis's fake camera does not use.
constexpr std::uint32_t kRegisterWantedPeriodUs = 0x400;

constexpr double kGainStepDb = 0.1;  ///< unit of the gain register
constexpr double kMaxGainDb = 48.0;

constexpr char kVendorName[] = "ovws";
constexpr char kModelName[] = "Bench twin";

/// GenICam XML with SFNC names: Width, Height, OffsetX, OffsetY, PixelFormat (all supported
/// formats), ExposureTime, Gain (dB), AcquisitionFrameRate, AcquisitionStart, … The registers are
/// those of Aravis's fake camera, which streams by them.
std::string_view genicam_xml();

}  // namespace ovws::twin
