#include "drivers/png/grey_png.hpp"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <memory>
#include <vector>

namespace ovws {
namespace {

static_assert(std::endian::native == std::endian::little, "png_set_swap below assumes it");

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;

  Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

// libpng reports errors by longjmp, so functions that call setjmp hold no objects with destructors.

bool read_header(png_structp png, png_infop info, std::FILE* file) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_init_io(png, file);
  png_read_info(png, info);
  return true;
}

bool read_pixels(png_structp png, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_swap(png);
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

std::string size_text(png_uint_32 width, png_uint_32 height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

Result<void> check_format(const Reader& reader, const std::string& path) {
  if (png_get_bit_depth(reader.png, reader.info) == 16 &&
      png_get_color_type(reader.png, reader.info) == PNG_COLOR_TYPE_GRAY) {
    return {};
  }
  return fail(Errc::invalid, "", path + " is not a 16-bit greyscale PNG: convert it");
}

/// Reads a file whose size `fits(cols, rows)` accepts: it returns what is wrong, or an empty text.
template <class Fits>
Result<Image<std::uint16_t>> read_if(const std::string& path, Fits fits) {
  const auto unreadable = [&] {
    return fail(Errc::invalid, "", "the PNG file " + path + " cannot be read");
  };
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) return unreadable();
  Reader reader;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  if (reader.png != nullptr) reader.info = png_create_info_struct(reader.png);
  if (reader.info == nullptr) return fail(Errc::internal, "", "libpng cannot be initialised");
  if (!read_header(reader.png, reader.info, file.get())) return unreadable();
  if (auto grey = check_format(reader, path); !grey) return fail(grey.error());
  const png_uint_32 cols = png_get_image_width(reader.png, reader.info);
  const png_uint_32 rows = png_get_image_height(reader.png, reader.info);
  if (const std::string wrong = fits(cols, rows); !wrong.empty()) {
    return fail(Errc::invalid, "", path + " is " + size_text(cols, rows) + " pixels, " + wrong);
  }
  Image<std::uint16_t> image{int(cols), int(rows)};
  std::vector<png_bytep> lines;
  for (int y = 0; y < image.height; ++y) {
    lines.push_back(reinterpret_cast<png_bytep>(image.row(y)));
  }
  if (!read_pixels(reader.png, lines.data())) return unreadable();
  return image;
}

}  // namespace

Result<Image<std::uint16_t>> read_grey16_png(const std::string& path, int width, int height) {
  return read_if(path, [=](png_uint_32 cols, png_uint_32 rows) {
    const bool fits = cols == png_uint_32(width) && rows == png_uint_32(height);
    return fits ? "" : "not " + size_text(png_uint_32(width), png_uint_32(height));
  });
}

Result<Image<std::uint16_t>> read_grey16_png(const std::string& path, int max_side) {
  return read_if(path, [=](png_uint_32 cols, png_uint_32 rows) {
    const bool fits = std::max(cols, rows) <= png_uint_32(max_side);
    return fits ? "" : "more than " + std::to_string(max_side) + " along a side";
  });
}

Result<std::string> encode_grey8_png(const Image<std::uint8_t>& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(image.width);
  header.height = png_uint_32(image.height);
  header.format = PNG_FORMAT_GRAY;
  header.flags = PNG_IMAGE_FLAG_FAST;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), image.width,
                                nullptr) == 0) {
    return fail(Errc::internal, "", "the image cannot be written as PNG");
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace ovws
