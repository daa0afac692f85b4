/// Downscales camera images for the browser.
#pragma once

#include <cstddef>
#include <vector>

#include "drivers/zmq/client.hpp"

namespace ovws::web {

constexpr int kMaxImageSide = 1024;

/// Bins an `image` message to at most kMaxImageSide pixels per side. Each pixel is the mean of
/// `reduced_by` x `reduced_by` camera pixels; the JSON part gets the key `reduced_by`. None if the
/// message does not conform to WIRE.md.
std::optional<StreamMessage> reduced_image(const StreamMessage& image);

}  // namespace ovws::web
