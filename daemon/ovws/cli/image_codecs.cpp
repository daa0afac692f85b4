#include "daemon/ovws/cli/image_codecs.hpp"

#include <opencv2/imgcodecs.hpp>

extern "C" const ovws::cli::ImageCodecs ovws_image_codecs;
const ovws::cli::ImageCodecs ovws_image_codecs{
    [](const std::string& path) { return cv::imcount(path, cv::IMREAD_UNCHANGED); },
    [](const std::string& path, int page) {
      if (page == 0) return cv::imread(path, cv::IMREAD_UNCHANGED);
      std::vector<cv::Mat> pages;
      cv::imreadmulti(path, pages, page, 1, cv::IMREAD_UNCHANGED);
      return pages.empty() ? cv::Mat() : pages.front();
    },
    [](const std::string& extension, const cv::Mat& picture, std::vector<unsigned char>& bytes) {
      return cv::imencode(extension, picture, bytes);
    }};
