#include "daemon/ovws/cli/image_file.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "daemon/ovws/cli/image_codecs.hpp"

namespace ovws::cli {
namespace {

/// The module's functions, or why it cannot be loaded.
tl::expected<const ImageCodecs*, std::string> image_codecs() {
  using Loaded = tl::expected<const ImageCodecs*, std::string>;
  static const auto loaded = []() -> Loaded {
    void* const module = dlopen(OVWS_IMAGE_CODECS, RTLD_NOW | RTLD_LOCAL);
    void* const codecs = module != nullptr ? dlsym(module, "ovws_image_codecs") : nullptr;
    if (codecs == nullptr) return tl::unexpected(std::string(dlerror()));
    return static_cast<const ImageCodecs*>(codecs);
  }();
  return loaded;
}

Error unreadable(const std::string& path, const std::string& why) {
  return {Errc::invalid, "image", path + " " + why};
}

template <class T>
Image<T> pixels_of(const cv::Mat& mat) {
  Image<T> image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr<T>(y), mat.cols, image.row(y));
  return image;
}

}  // namespace

Error cannot_write(const std::filesystem::path& path, const std::string& why) {
  return {Errc::unavailable, "output", path.string() + " cannot be written: " + why};
}

std::string why_not_opened(const std::filesystem::path& path, int error_number) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  if (!std::filesystem::exists(folder, ignored)) {
    return "the folder " + folder.string() + " does not exist";
  }
  return std::string(std::strerror(error_number)) + " (the folder " + folder.string() + " exists)";
}

Result<void> write_image(const std::filesystem::path& path, const cv::Mat& picture) {
  const auto codecs = image_codecs();
  if (!codecs) return fail(cannot_write(path, codecs.error()));
  std::vector<unsigned char> bytes;
  const std::string format = path.has_extension() ? path.extension().string() : ".png";
  try {
    if (!(*codecs)->encode(format, picture, bytes))
      return fail(cannot_write(path, "encoding as " + format + " failed"));
  } catch (const cv::Exception&) {
    return fail(cannot_write(path, "there is no image format " + format));
  }
  // A file is written beside it and renamed at the end: a failure leaves the old one as it was.
  std::error_code ignored;
  const auto kind = std::filesystem::symlink_status(path, ignored).type();
  const bool is_file =
      kind == std::filesystem::file_type::regular || kind == std::filesystem::file_type::not_found;
  const std::string part = path.string() + (is_file ? ".part" : "");
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (file == nullptr) return fail(cannot_write(path, why_not_opened(path, errno)));
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const bool closed = std::fclose(file) == 0;
  if (written && closed && (!is_file || std::rename(part.c_str(), path.c_str()) == 0)) return {};
  const std::string why = std::strerror(errno);
  if (is_file) std::remove(part.c_str());
  return fail(cannot_write(path, why));
}

ImageView Picture::view() const {
  return narrow.pixels.empty() ? view_of(wide, PixelFormat::mono16) : view_of(narrow);
}

Result<Picture> read_image(const std::string& path) {
  if (std::error_code none; !std::filesystem::exists(path, none)) {
    return fail(unreadable(path, "does not exist"));
  }
  const auto codecs = image_codecs();
  if (!codecs) return fail(unreadable(path, codecs.error()));
  cv::Mat mat;
  try {
    mat = (*codecs)->read(path);
  } catch (const cv::Exception&) {
    return fail(unreadable(path, "cannot be read: the size in its header is too large"));
  }
  if (mat.empty()) return fail(unreadable(path, "cannot be read as an image"));
  Picture picture;
  if (mat.type() == CV_8UC1) {
    picture.narrow = pixels_of<std::uint8_t>(mat);
  } else if (mat.type() == CV_16UC1) {
    picture.wide = pixels_of<std::uint16_t>(mat);
  } else {
    return fail(unreadable(
        path, "is not greyscale with 8 or 16 bits: convert it, e.g. to a greyscale TIFF"));
  }
  return picture;
}

cv::Mat phase_colours(const cv::Mat& waves, double scale, const cv::Scalar& background) {
  cv::Mat levels, colours;
  waves.convertTo(levels, CV_8U, 127.5 / scale, 127.5);
  cv::applyColorMap(levels, colours, cv::COLORMAP_VIRIDIS);
  cv::Mat picture(waves.size(), CV_8UC3, background);
  colours.copyTo(picture, waves == waves);  // NaN is not equal to itself
  return picture;
}

}  // namespace ovws::cli
