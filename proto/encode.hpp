/// Messages to bytes, exactly as WIRE.md says them: strict JSON (what is not finite is null) and
/// little-endian binary parts. Buffers are the caller's and are reused.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/messages.hpp"
#include "proto/tables/status.hpp"

namespace ovws {

// Topics, also the first frame of each multipart message.
constexpr std::string_view kTopicWavefront = "wavefront";
constexpr std::string_view kTopicSpots = "spots";
constexpr std::string_view kTopicImage = "image";
constexpr std::string_view kTopicPhase = "phase";
constexpr std::string_view kTopicRefined = "refined";
constexpr std::string_view kTopicStatus = "status";
constexpr std::string_view kTopicEvent = "event";

// Each replaces `json`. The bytes returned are the binary part, borrowed from the message's own
// pixels or from `scratch`; valid until either changes. Reentrant; no allocation once the buffers
// have grown.
void encode(const WavefrontMessage& message, std::string& json);
std::span<const std::byte> encode(const SpotsMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch);
std::span<const std::byte> encode(const ImageMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch);
std::span<const std::byte> encode(const PhaseMessage& message, std::string& json);

// These are rare and may allocate.
std::string encode(const RefinedMessage& message);
std::string encode(const StatusMessage& message);
std::string encode(const EventMessage& message);

}  // namespace ovws
