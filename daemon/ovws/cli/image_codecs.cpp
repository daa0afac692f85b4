#include "daemon/ovws/cli/image_codecs.hpp"

#include <opencv2/imgcodecs.hpp>

extern "C" const ovws::cli::ImageCodecs ovws_image_codecs;
const ovws::cli::ImageCodecs ovws_image_codecs{
    [](const std::string& path) { return cv::imread(path, cv::IMREAD_UNCHANGED); },
    [](const std::string& extension, const cv::Mat& picture, std::vector<unsigned char>& bytes) {
      return cv::imencode(extension, picture, bytes);
    }};
