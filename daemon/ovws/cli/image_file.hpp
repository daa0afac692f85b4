/// Files that commands read and write: images, and output of any kind. Also maps phases to colours.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <utility>

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

/// The camera's bits in the words of 16-bit images.
struct Depth {
  PixelFormat format = PixelFormat::mono16;  ///< Mono10 to Mono16
  int left_justified_bits = 0;               ///< see ImageView
};

/// A greyscale image of 8 or 16 bits.
struct Picture {
  Image<std::uint8_t> narrow;
  Image<std::uint16_t> wide;  ///< used for 16-bit images; else empty
  Depth depth;                ///< of `wide`
  ImageView view() const;
};

/// A PNG, TIFF or PGM file.
class ImageFile {
 public:
  /// `camera`: the camera's pixel format; of 16-bit images it gives the number of bits, unless the
  /// pixels exceed it. With 8 bits the pixels tell it: bits that are 0 in all words are left out
  /// (MSB-aligned data), and if the largest value is that of 10, 12 or 14 bits, and at least four
  /// pixels have it, that is the full scale. Errors (Errc::invalid, field "image"): it does not
  /// exist.
  static Result<ImageFile> open(const std::string& path, PixelFormat camera);

  /// Number of images: the pages of a TIFF stack, else 1.
  int count() const { return count_; }
  /// Reads image `page` (from 0 on). All 16-bit images have the depth that the words of all pages
  /// tell; the first of them takes the time to read all. Errors (Errc::invalid, field "image"):
  /// unreadable, or not greyscale with 8 or 16 bits.
  Result<Picture> read(int page);

 private:
  ImageFile(std::string path, PixelFormat camera, int count)
      : path_(std::move(path)), camera_(camera), count_(count) {}
  Result<cv::Mat> decode(int page) const;
  /// The depth by all pages, of which `image` is one.
  Depth find_depth(int page, const Image<std::uint16_t>& image) const;

  std::string path_;
  PixelFormat camera_;
  int count_;
  std::optional<Depth> depth_;
};

/// The image as a matrix on the same pixels, which must not be changed by it.
template <class Pixel>
cv::Mat matrix_on(const Image<Pixel>& image) {
  // cv::Mat has no constructor for const pixels.
  return cv::Mat(image.height, image.width, cv::DataType<Pixel>::type,
                 const_cast<Pixel*>(image.pixels.data()));
}

/// Maps -scale to +scale waves (CV_32FC1) to the viridis colours; NaN shows `background`.
cv::Mat phase_colours(const cv::Mat& waves, double scale, const cv::Scalar& background);

}  // namespace ovws::cli
