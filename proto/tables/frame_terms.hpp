/// Terms that the messages about frames share.
#pragma once

#include <array>

#include "proto/field.hpp"
#include "proto/limits.hpp"

namespace ovws {

inline constexpr const char* kFrameIdMeaning = "camera's frame number";
inline constexpr const char* kArrivalMeaning =
    "frame complete in the daemon, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kPublishMeaning = "message built, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kFrameHologramMeaning =
    "number of the hologram on the SLM during the exposure, or of the newest if it changed or had "
    "not settled; 0: unknown";
inline constexpr const char* kPatternMeaning =
    "number of the pattern of aberration.sequence that this frame shows, from 0; null: no sequence "
    "is shown, or the pattern is not certain, and then the frame is neither settled nor valid";
inline constexpr Bounds kPatternBounds{0, limits::kPatternSlots.max - 2};
/// Shape of a binary part: rows, columns.
using Shape = std::array<int, 2>;
inline constexpr const char* kDtypeMeaning = "NumPy dtype of the binary part, little-endian";

}  // namespace ovws
