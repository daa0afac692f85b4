/// Image files: reads and writes them, and says why a file could not be written. Also maps phases
/// to colours.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::cli {

Error cannot_write(const std::filesystem::path& path, const std::string& why);

/// Why a file could not be opened: its folder is missing, or the system's error text.
std::string why_not_opened(const std::filesystem::path& path, int error_number);

/// Writes the image in the format of the file name's extension, or as PNG if it has no extension.
/// Errors: Errc::unavailable, field "output".
Result<void> write_image(const std::filesystem::path& path, const cv::Mat& picture);

/// A greyscale image of 8 or 16 bits.
struct Picture {
  Image<std::uint8_t> narrow;
  Image<std::uint16_t> wide;  ///< used for 16-bit images; else empty
  ImageView view() const;
};
/// Reads a PNG, TIFF or PGM file. Errors (Errc::invalid, field "image"): unreadable, or not
/// greyscale with 8 or 16 bits.
Result<Picture> read_image(const std::string& path);

/// Maps -scale to +scale waves (CV_32FC1) to the viridis colours; NaN shows `background`.
cv::Mat phase_colours(const cv::Mat& waves, double scale, const cv::Scalar& background);

}  // namespace ovws::cli
