#include "daemon/web/picture.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "proto/json_text.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

struct Size {
  int rows = 0, cols = 0;
};

/// Header of an image whose binary part has the size that it states.
struct Layout {
  json header;
  Size size;
  bool wide = false;  ///< two bytes per pixel
  unsigned full = 0;  ///< grey level of full scale

  std::size_t bytes_per_pixel() const { return wide ? 2 : 1; }
};

std::optional<Layout> layout_of(const StreamMessage& image) {
  Layout layout{json_of(image.json), {}, false, 0};
  if (!layout.header.is_object()) return std::nullopt;
  const json& shape = layout.header.at("shape");
  layout.size = {shape.at(0).get<int>(), shape.at(1).get<int>()};
  layout.wide = layout.header.at("dtype") == "<u2";
  const int most_bits = layout.wide ? 16 : 8;
  const int bits = layout.header.value("significant_bits", most_bits);
  layout.full = (1U << unsigned(std::clamp(bits, 1, most_bits))) - 1U;
  const Size size = layout.size;
  if (size.rows < 1 || size.cols < 1) return std::nullopt;
  const std::size_t pixels = std::size_t(size.rows) * std::size_t(size.cols);
  if (image.binary.size() != pixels * layout.bytes_per_pixel()) return std::nullopt;
  return layout;
}

/// Adds the histogram, the number of saturated pixels and the brightest level to the header.
template <class Pixel>
void count_levels(const std::vector<std::byte>& pixels, unsigned full, json& header) {
  std::vector<std::uint32_t> counts(std::size_t(full) + 1);
  for (std::size_t at = 0; at < pixels.size(); at += sizeof(Pixel)) {
    Pixel value{};
    std::memcpy(&value, pixels.data() + at, sizeof(Pixel));
    ++counts[std::min<unsigned>(value, full)];
  }
  std::array<std::uint32_t, kHistogramBins> bins{};
  unsigned brightest = 0;
  for (unsigned level = 0; level <= full; ++level) {
    if (counts[level] > 0) brightest = level;
    bins[std::size_t(level) * kHistogramBins / (std::size_t(full) + 1)] += counts[level];
  }
  header["histogram"] = bins;
  header["saturated_pixels"] = counts[full];
  header["brightest_dn"] = brightest;
}

template <class Pixel>
std::vector<std::byte> means(const std::vector<std::byte>& from, Size size, int step,
                             unsigned full) {
  const Size out{size.rows / step, size.cols / step};
  std::vector<std::byte> to(std::size_t(out.rows) * out.cols * sizeof(Pixel));
  std::vector<std::uint32_t> sums(std::size_t(out.cols));
  std::vector<bool> saturated(std::size_t(out.cols));
  std::vector<Pixel> row(std::size_t(out.cols) * step);
  for (int y = 0; y < out.rows; ++y) {
    std::fill(sums.begin(), sums.end(), 0U);
    std::fill(saturated.begin(), saturated.end(), false);
    for (int k = 0; k < step; ++k) {
      const std::size_t first = (std::size_t(y) * step + k) * std::size_t(size.cols);
      std::memcpy(row.data(), from.data() + first * sizeof(Pixel), row.size() * sizeof(Pixel));
      for (std::size_t x = 0; x < row.size(); ++x) {
        sums[x / std::size_t(step)] += row[x];
        if (row[x] >= full) saturated[x / std::size_t(step)] = true;
      }
    }
    for (int x = 0; x < out.cols; ++x) {
      const auto mean = saturated[std::size_t(x)]
                            ? Pixel(full)
                            : Pixel(sums[std::size_t(x)] / std::uint32_t(step * step));
      const std::size_t at = (std::size_t(y) * out.cols + x) * sizeof(Pixel);
      std::memcpy(to.data() + at, &mean, sizeof(Pixel));
    }
  }
  return to;
}

}  // namespace

std::optional<StreamMessage> reduced_image(const StreamMessage& image) {
  auto layout = layout_of(image);
  if (!layout) return std::nullopt;
  const auto [size, wide, full] = std::tuple(layout->size, layout->wide, layout->full);
  json& header = layout->header;
  wide ? count_levels<std::uint16_t>(image.binary, full, header)
       : count_levels<std::uint8_t>(image.binary, full, header);
  const int step = (std::max(size.rows, size.cols) + kMaxImageSide - 1) / kMaxImageSide;
  header["reduced_by"] = step;
  StreamMessage reduced{image.topic, {}, {}};
  if (step == 1) {
    reduced.binary = image.binary;
  } else {
    reduced.binary = wide ? means<std::uint16_t>(image.binary, size, step, full)
                          : means<std::uint8_t>(image.binary, size, step, full);
    header["shape"] = {size.rows / step, size.cols / step};
    header["whole_shape"] = {size.rows, size.cols};
  }
  reduced.json = json_text(header);
  return reduced;
}

std::optional<ImagePart> parse_image_part(std::string_view query) {
  ImagePart part;
  for (const auto& [name, value] :
       std::initializer_list<std::pair<std::string_view, int*>>{{"x=", &part.x},
                                                                {"&y=", &part.y},
                                                                {"&width=", &part.width},
                                                                {"&height=", &part.height}}) {
    if (!query.starts_with(name)) return std::nullopt;
    query.remove_prefix(name.size());
    const auto [end, error] = std::from_chars(query.data(), query.data() + query.size(), *value);
    if (error != std::errc() || *value < 0) return std::nullopt;
    query.remove_prefix(std::size_t(end - query.data()));
  }
  return query.empty() ? std::optional(part) : std::nullopt;
}

std::optional<StreamMessage> image_part(const StreamMessage& image, ImagePart part) {
  auto layout = layout_of(image);
  if (!layout) return std::nullopt;
  const Size size = layout->size;
  const int left = std::min(part.x, size.cols), top = std::min(part.y, size.rows);
  const int cols = std::min(part.width, size.cols - left);
  const int rows = std::min(part.height, size.rows - top);
  if (cols < 1 || rows < 1) return std::nullopt;
  const std::size_t pixel = layout->bytes_per_pixel();
  StreamMessage cut{image.topic, {}, {}};
  cut.binary.reserve(std::size_t(rows) * std::size_t(cols) * pixel);
  for (int y = top; y < top + rows; ++y) {
    const std::size_t first = (std::size_t(y) * std::size_t(size.cols) + std::size_t(left)) * pixel;
    const auto from = image.binary.begin() + std::ptrdiff_t(first);
    cut.binary.insert(cut.binary.end(), from, from + std::ptrdiff_t(std::size_t(cols) * pixel));
  }
  layout->header["shape"] = {rows, cols};
  layout->header["x"] = left;
  layout->header["y"] = top;
  cut.json = json_text(layout->header);
  return cut;
}

}  // namespace ovws::web
