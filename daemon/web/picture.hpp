/// Camera images small enough for a browser.
#pragma once

#include <cstddef>
#include <vector>

#include "drivers/zmq/client.hpp"

namespace ovws::web {

constexpr int kMostPictureSide = 1024;

/// An `image` message whose sides have at most kMostPictureSide pixels, each the mean of a square
/// of `reduced_by` x `reduced_by` camera pixels; its JSON has that key added. None if the message
/// is not what WIRE.md says.
std::optional<StreamMessage> reduced_image(const StreamMessage& image);

}  // namespace ovws::web
