/// Image files: writes them, and says why a file could not be written. Also maps phases to colours.
#pragma once

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::cli {

inline Result<void> cannot_write(const std::filesystem::path& path, const std::string& why) {
  return fail(Errc::unavailable, "output", path.string() + " cannot be written: " + why);
}

/// Why a file could not be opened: its folder is missing, or the system's error text.
inline std::string why_not_opened(const std::filesystem::path& path, int error_number) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  if (!std::filesystem::exists(folder, ignored)) {
    return "the folder " + folder.string() + " does not exist";
  }
  return std::string(std::strerror(error_number)) + " (the folder " + folder.string() + " exists)";
}

/// Writes the image in the format of the file name's extension, or as PNG if it has no extension.
inline Result<void> write_image(const std::filesystem::path& path, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  const std::string format = path.has_extension() ? path.extension().string() : ".png";
  try {
    if (!cv::imencode(format, picture, bytes))
      return cannot_write(path, "encoding as " + format + " failed");
  } catch (const cv::Exception&) {
    return cannot_write(path, "there is no image format " + format);
  }
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return cannot_write(path, why_not_opened(path, errno));
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) return cannot_write(path, std::strerror(errno));
  return {};
}

/// Maps -scale to +scale waves (CV_32FC1) to the viridis colours; NaN shows `background`.
inline cv::Mat phase_colours(const cv::Mat& waves, double scale, const cv::Scalar& background) {
  cv::Mat levels, colours;
  waves.convertTo(levels, CV_8U, 127.5 / scale, 127.5);
  cv::applyColorMap(levels, colours, cv::COLORMAP_VIRIDIS);
  cv::Mat picture(waves.size(), CV_8UC3, background);
  colours.copyTo(picture, waves == waves);  // NaN is not equal to itself
  return picture;
}

}  // namespace ovws::cli
