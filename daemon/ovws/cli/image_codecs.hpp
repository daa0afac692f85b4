/// OpenCV's image formats as a module of their own. Its libraries load a hundred others, which
/// takes four times as long as all the rest of `ovws`: only commands that need images load it.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ovws::cli {

/// What the module exports by the name kImageCodecs. Both functions may throw cv::Exception.
struct ImageCodecs {
  /// Pixels of a file as they are, empty if it is not an image.
  cv::Mat (*read)(const std::string& path);
  /// `picture` in the format of a file name's extension, e.g. ".png". False: it cannot be encoded.
  bool (*encode)(const std::string& extension, const cv::Mat& picture,
                 std::vector<unsigned char>& bytes);
};
inline constexpr char kImageCodecs[] = "ovws_image_codecs";

}  // namespace ovws::cli
