/// Encoding of stream messages as in WIRE.md: strict JSON (non-finite numbers become null) and
/// little-endian binary parts. The caller owns and reuses the buffers.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/messages.hpp"
#include "proto/status_message.hpp"

namespace ovws {

// Topic names: the first frame of each multipart message.
constexpr std::string_view kTopicWavefront = "wavefront";
constexpr std::string_view kTopicSpots = "spots";
constexpr std::string_view kTopicCorrector = "corrector";
constexpr std::string_view kTopicImage = "image";
constexpr std::string_view kTopicPhase = "phase";
constexpr std::string_view kTopicRefined = "refined";
constexpr std::string_view kTopicStatus = "status";
constexpr std::string_view kTopicEvent = "event";

// Each `encode` replaces `json` and returns the binary part, if the message has one. The returned
// span refers to the message's pixels or commands, or to `scratch` and is valid until they change.
// Reentrant; no allocation once the buffers have grown.
void encode(const WavefrontMessage& message, std::string& json);
std::span<const std::byte> encode(const SpotsMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch);
std::span<const std::byte> encode(const CorrectorMessage& message, std::string& json);
std::span<const std::byte> encode(const ImageMessage& message, std::string& json,
                                  std::vector<std::byte>& scratch);
std::span<const std::byte> encode(const PhaseMessage& message, std::string& json);

// Refinements, status and events are rare messages, so encoding them may allocate memory.
std::string encode(const RefinedMessage& message);
std::string encode(const StatusMessage& message);
std::string encode(const EventMessage& message);

}  // namespace ovws
