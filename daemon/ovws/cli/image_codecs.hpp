/// OpenCV's image formats as a module of their own, which only commands with images load: its
/// libraries take longer to load than the rest of `ovws`.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ovws::cli {

/// What the module exports as `ovws_image_codecs`. Both functions may throw cv::Exception.
struct ImageCodecs {
  /// Pixels of a file as they are, empty if it is not an image.
  cv::Mat (*read)(const std::string& path);
  /// `picture` in the format of a file name's extension, e.g. ".png". False: it cannot be encoded.
  bool (*encode)(const std::string& extension, const cv::Mat& picture,
                 std::vector<unsigned char>& bytes);
};

}  // namespace ovws::cli
