/// GenICam description of the twin's camera, and the registers that the twin adds.
#pragma once

#include <cstdint>
#include <string_view>

namespace ovws::twin {

// Registers in memory that Aravis's fake camera does not use. With its own trigger mode it would
// wait for software triggers.
constexpr std::uint32_t kRegisterWantedPeriodUs = 0x400;
constexpr std::uint32_t kRegisterTriggerMode = 0x404;          ///< 1: on
constexpr std::uint32_t kRegisterResultingPeriod10Ns = 0x408;  ///< units of 10 ns

constexpr double kGainStepDb = 0.1;  ///< unit of the gain register
constexpr double kMaxGainDb = 48.0;

constexpr char kVendorName[] = "ovws";
constexpr char kModelName[] = "Bench twin";

/// GenICam XML with SFNC names: Width, Height, OffsetX, OffsetY, PixelFormat (all supported
/// formats), ExposureTime, Gain (dB), AcquisitionFrameRate, AcquisitionStart, TriggerMode, … The
/// features map to the registers of Aravis's fake camera, which control its stream.
std::string_view genicam_xml();

}  // namespace ovws::twin
