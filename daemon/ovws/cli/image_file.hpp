/// Files that commands read and write: images, and output of any kind. Also maps phases to colours.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <ostream>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::cli {

/// Writes a file by `write`, beside it, and renames that at the end: a failure leaves the old file
/// as it was. What is not a file, such as a pipe or a symbolic link, is written in place.
/// Errors: those of `write`; Errc::unavailable, field "output".
Result<void> write_output(const std::filesystem::path& path,
                          const std::function<Result<void>(std::ostream&)>& write);

/// Writes the image in the format of the file name's extension, or as PNG if it has no extension.
/// Errors: Errc::unavailable, field "output".
Result<void> write_image(const std::filesystem::path& path, const cv::Mat& picture);

/// A greyscale image of 8 or 16 bits.
struct Picture {
  Image<std::uint8_t> narrow;
  Image<std::uint16_t> wide;  ///< used for 16-bit images; else empty
  /// Of `wide`: Mono10 to Mono16, by the camera's bits in each word.
  PixelFormat format = PixelFormat::mono16;
  int left_justified_bits = 0;  ///< of `wide`: see ImageView
  ImageView view() const;
};
/// Number of images in a PNG, TIFF or PGM file: the pages of a TIFF stack, else 1. Errors
/// (Errc::invalid, field "image"): it does not exist.
Result<int> count_images(const std::string& path);
/// Reads image `page` (from 0 on) of a file. `camera`: the camera's pixel format; of a 16-bit image
/// it gives the number of bits, unless the pixels exceed it. With 8 bits the pixels tell it: bits
/// that are 0 in all words are left out (MSB-aligned data), and if the largest value is that of 10,
/// 12 or 14 bits, and at least four pixels have it, that is the full scale. Errors (Errc::invalid,
/// field "image"): unreadable, or not greyscale with 8 or 16 bits.
Result<Picture> read_image(const std::string& path, int page, PixelFormat camera);

/// Maps -scale to +scale waves (CV_32FC1) to the viridis colours; NaN shows `background`.
cv::Mat phase_colours(const cv::Mat& waves, double scale, const cv::Scalar& background);

}  // namespace ovws::cli
