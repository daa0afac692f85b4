#include "daemon/ovws/cli/image_codecs.hpp"

#include <tiffio.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace ovws::cli {
namespace {

std::string damage;  // libtiff's first error since it was cleared

void take_error(thandle_t /*file*/, const char* /*function*/, const char* format,
                std::va_list arguments) {
  std::array<char, 300> text{};
  if (damage.empty() && std::vsnprintf(text.data(), text.size(), format, arguments) > 0)
    damage = text.data();
}

std::size_t count_images(const std::string& path) {
  TIFFSetErrorHandlerExt(take_error);  // called beside the handler that OpenCV sets
  damage.clear();
  const std::size_t count = cv::imcount(path, cv::IMREAD_UNCHANGED);
  return damage.empty() ? count : count + 1;
}

cv::Mat read_image(const std::string& path, int page) {
  TIFFSetErrorHandlerExt(take_error);
  damage.clear();
  std::vector<cv::Mat> pages;
  if (page == 0) {
    pages.push_back(cv::imread(path, cv::IMREAD_UNCHANGED));
  } else {
    cv::imreadmulti(path, pages, page, 1, cv::IMREAD_UNCHANGED);
  }
  if (!damage.empty()) throw std::runtime_error(damage);
  return pages.empty() ? cv::Mat() : pages.front();
}

bool encode_image(const std::string& extension, const cv::Mat& picture,
                  std::vector<unsigned char>& bytes) {
  return cv::imencode(extension, picture, bytes);
}

}  // namespace
}  // namespace ovws::cli

extern "C" const ovws::cli::ImageCodecs ovws_image_codecs;
const ovws::cli::ImageCodecs ovws_image_codecs{ovws::cli::count_images, ovws::cli::read_image,
                                               ovws::cli::encode_image};
