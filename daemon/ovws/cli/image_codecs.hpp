/// OpenCV's image formats as a module of their own, which only commands with images load: its
/// libraries take longer to load than the rest of `ovws`.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ovws::cli {

/// What the module exports as `ovws_image_codecs`. The functions may throw cv::Exception.
struct ImageCodecs {
  /// Number of images in a file, such as the pages of a TIFF stack; 0: it is not an image. Of a
  /// TIFF whose list of pages is damaged one more than are found, which `read` refuses.
  std::size_t (*count)(const std::string& path);
  /// Pixels of image `page` (from 0 on) of a file as they are; empty: it is not an image. Throws
  /// std::runtime_error with libtiff's own words if a TIFF is damaged: OpenCV returns what could be
  /// decoded, and says nothing.
  cv::Mat (*read)(const std::string& path, int page);
  /// `picture` in the format of a file name's extension, e.g. ".png". False: it cannot be encoded.
  bool (*encode)(const std::string& extension, const cv::Mat& picture,
                 std::vector<unsigned char>& bytes);
};

}  // namespace ovws::cli
