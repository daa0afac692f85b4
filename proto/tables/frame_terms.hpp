/// Terms that the messages about frames share.
#pragma once

#include <array>

namespace ovws {

inline constexpr const char* kFrameIdMeaning = "camera's frame number";
inline constexpr const char* kArrivalMeaning =
    "frame complete in the daemon, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kPublishMeaning = "message built, UNIX epoch UTC, nanoseconds";
inline constexpr const char* kFrameHologramMeaning =
    "number of the hologram on the SLM during the exposure, or of the newest if it changed or had "
    "not settled; 0: unknown";
/// Shape of a binary part: rows, columns.
using Shape = std::array<int, 2>;
inline constexpr const char* kDtypeMeaning = "NumPy dtype of the binary part, little-endian";

}  // namespace ovws
