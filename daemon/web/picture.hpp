/// Prepares camera images for the browser: reduces large ones, counts grey levels, cuts parts out.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "drivers/zmq/client.hpp"

namespace ovws::web {

using CameraImagePtr = std::shared_ptr<const StreamMessage>;  ///< an `image` message

constexpr int kMaxImageSide = 1024;
constexpr int kHistogramBins = 128;

/// Bins an `image` message to at most kMaxImageSide pixels per side. Each pixel is the mean of
/// `reduced_by` x `reduced_by` camera pixels, or full scale if one of them is saturated. None if
/// the message does not conform to WIRE.md. The JSON part gets these keys, which count all pixels
/// of the camera's image:
///   reduced_by
///   whole_shape        rows and columns of the camera's image, if it was reduced
///   histogram          kHistogramBins counts over the range from 0 to full scale
///   saturated_pixels   number of pixels at full scale
///   brightest_dn       grey level of the brightest pixel
std::optional<StreamMessage> reduced_image(const StreamMessage& image);

/// Part of an image, pixels of the image.
struct ImagePart {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Parses "x=0&y=0&width=64&height=48": exactly these four non-negative numbers in this order.
std::optional<ImagePart> parse_image_part(std::string_view query);

/// Cuts a part out of an `image` message that reduced_image accepts, clipped to the image. The JSON
/// part gets the part's `x` and `y`. None if nothing is left.
std::optional<StreamMessage> image_part(const StreamMessage& image, ImagePart part);

}  // namespace ovws::web
