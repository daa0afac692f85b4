#include "daemon/ovws/cli/image_file.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "daemon/ovws/cli/image_codecs.hpp"

namespace ovws::cli {
namespace {

namespace fs = std::filesystem;

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

PixelFormat mono_of(int bits) {
  return bits == 10   ? PixelFormat::mono10
         : bits == 12 ? PixelFormat::mono12
         : bits == 14 ? PixelFormat::mono14
                      : PixelFormat::mono16;
}

constexpr std::array kDepths{10, 12, 14};
constexpr std::ptrdiff_t kFlatTopPixels = 4;  // by chance fewer have the largest value

/// What the words of 16-bit images tell of their depth.
struct PixelWords {
  unsigned used = 0, most = 0;  ///< bits that are not 0 in all words; the largest word
  std::ptrdiff_t at_most = 0;   ///< number of the largest

  void add(std::span<const std::uint16_t> words) {
    for (const unsigned word : words) {
      used |= word;
      if (word > most) at_most = 0;
      most = std::max(most, word);
      at_most += word == most ? 1 : 0;
    }
  }
};

/// See ImageFile::open.
Depth depth_of(const PixelWords& words, int camera_bits) {
  const unsigned most = words.most;
  if (camera_bits > 8 && (most >> camera_bits) == 0) return {mono_of(camera_bits), 0};
  Depth depth;
  const int free = words.used == 0 ? 0 : std::countr_zero(words.used);
  // The daemon takes MSB-aligned words in the same way.
  const auto aligned = std::ranges::find_if(kDepths, [&](int bits) {
    return 16 - bits <= free && most >> unsigned(bits) != 0 &&
           (camera_bits <= 8 || bits == camera_bits);
  });
  if (aligned != kDepths.end()) {
    depth = {mono_of(*aligned), 16 - *aligned};
  }
  const unsigned full = most >> unsigned(depth.left_justified_bits);
  for (const int bits : kDepths) {
    const bool flat_top = full == (1U << unsigned(bits)) - 1 && words.at_most >= kFlatTopPixels;
    if (camera_bits <= 8 && flat_top) depth.format = mono_of(bits);
  }
  return depth;
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return {Errc::unavailable, "output", path.string() + " cannot be written: " + why};
}

/// Why a file could not be opened: its folder is missing, or the system's error text.
std::string why_not_opened(const fs::path& path, int error_number) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  if (!fs::exists(folder, ignored)) return "the folder " + folder.string() + " does not exist";
  return std::string(std::strerror(error_number)) + " (the folder " + folder.string() + " exists)";
}

}  // namespace

Result<void> write_output(const fs::path& path,
                          const std::function<Result<void>(std::ostream&)>& write) {
  std::error_code failed;
  const auto kind = fs::symlink_status(path, failed).type();
  const bool is_file = kind == fs::file_type::regular || kind == fs::file_type::not_found;
  const fs::path part = path.string() + (is_file ? ".part" : "");
  std::ofstream out(part, std::ios::binary);
  if (!out) return fail(cannot_write(path, why_not_opened(path, errno)));
  errno = 0;
  auto written = write(out);
  out.close();
  if (written && !out)
    written = fail(cannot_write(path, errno != 0 ? std::strerror(errno) : "is its disk full?"));
  if (!is_file) return written;
  if (written) fs::rename(part, path, failed);
  if (written && failed) written = fail(cannot_write(path, failed.message()));
  if (!written) fs::remove(part, failed);
  return written;
}

Result<void> write_image(const fs::path& path, const cv::Mat& picture) {
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
  return write_output(path, [&bytes](std::ostream& out) -> Result<void> {
    out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return {};
  });
}

ImageView Picture::view() const {
  if (!narrow.pixels.empty()) return view_of(narrow);
  ImageView view = view_of(wide, depth.format);
  view.left_justified_bits = depth.left_justified_bits;
  return view;
}

Result<ImageFile> ImageFile::open(const std::string& path, PixelFormat camera) {
  if (std::error_code none; !fs::exists(path, none)) {
    return fail(unreadable(path, "does not exist"));
  }
  const auto codecs = image_codecs();
  if (!codecs) return fail(unreadable(path, codecs.error()));
  int count = 1;
  try {
    count = std::max(1, int((*codecs)->count(path)));
  } catch (const cv::Exception&) {
    // `read` says what is wrong with it.
  }
  return ImageFile(path, camera, count);
}

Result<cv::Mat> ImageFile::decode(int page) const {
  const auto codecs = image_codecs();
  if (!codecs) return fail(unreadable(path_, codecs.error()));
  try {
    cv::Mat mat = (*codecs)->read(path_, page);
    if (!mat.empty()) return mat;
  } catch (const cv::Exception&) {
    return fail(unreadable(path_, "cannot be read: the size in its header is too large"));
  } catch (const std::runtime_error& damage) {
    return fail(unreadable(path_, std::string("is damaged: ") + damage.what()));
  }
  return fail(unreadable(path_, "cannot be read as an image"));
}

Depth ImageFile::find_depth(int page, const Image<std::uint16_t>& image) const {
  PixelWords words;
  words.add(image.pixels);
  for (int other = 0; other < count_; ++other) {
    if (other == page) continue;
    const auto mat = decode(other);
    if (mat && mat->type() == CV_16UC1) words.add(pixels_of<std::uint16_t>(*mat).pixels);
  }
  return depth_of(words, significant_bits(camera_));
}

Result<Picture> ImageFile::read(int page) {
  const auto mat = decode(page);
  if (!mat) return fail(mat.error());
  Picture picture;
  if (mat->type() == CV_8UC1) {
    picture.narrow = pixels_of<std::uint8_t>(*mat);
  } else if (mat->type() == CV_16UC1) {
    picture.wide = pixels_of<std::uint16_t>(*mat);
    if (!depth_) depth_ = find_depth(page, picture.wide);
    picture.depth = *depth_;
  } else {
    return fail(unreadable(
        path_, "is not greyscale with 8 or 16 bits: convert it, e.g. to a greyscale TIFF"));
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
