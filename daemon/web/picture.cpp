#include "daemon/web/picture.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "proto/json_text.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

struct Size {
  int rows = 0, cols = 0;
};

template <class Pixel>
std::vector<std::byte> means(const std::vector<std::byte>& from, Size size, int step) {
  const Size out{size.rows / step, size.cols / step};
  std::vector<std::byte> to(std::size_t(out.rows) * out.cols * sizeof(Pixel));
  std::vector<std::uint32_t> sums(std::size_t(out.cols));
  std::vector<Pixel> row(std::size_t(out.cols) * step);
  for (int y = 0; y < out.rows; ++y) {
    std::fill(sums.begin(), sums.end(), 0U);
    for (int k = 0; k < step; ++k) {
      const std::size_t first = (std::size_t(y) * step + k) * std::size_t(size.cols);
      std::memcpy(row.data(), from.data() + first * sizeof(Pixel), row.size() * sizeof(Pixel));
      for (std::size_t x = 0; x < row.size(); ++x) sums[x / std::size_t(step)] += row[x];
    }
    for (int x = 0; x < out.cols; ++x) {
      const auto mean = Pixel(sums[std::size_t(x)] / std::uint32_t(step * step));
      const std::size_t at = (std::size_t(y) * out.cols + x) * sizeof(Pixel);
      std::memcpy(to.data() + at, &mean, sizeof(Pixel));
    }
  }
  return to;
}

}  // namespace

std::optional<StreamMessage> reduced_image(const StreamMessage& image) {
  json header = json_of(image.json);
  if (!header.is_object()) return std::nullopt;
  const Size size{header.at("shape").at(0).get<int>(), header.at("shape").at(1).get<int>()};
  const bool wide = header.at("dtype") == "<u2";
  const std::size_t bytes = std::size_t(size.rows) * size.cols * (wide ? 2 : 1);
  if (size.rows < 1 || size.cols < 1 || image.binary.size() != bytes) return std::nullopt;
  const int step = (std::max(size.rows, size.cols) + kMaxImageSide - 1) / kMaxImageSide;
  header["reduced_by"] = step;
  StreamMessage reduced{image.topic, {}, {}};
  if (step == 1) {
    reduced.binary = image.binary;
  } else {
    reduced.binary = wide ? means<std::uint16_t>(image.binary, size, step)
                          : means<std::uint8_t>(image.binary, size, step);
    header["shape"] = {size.rows / step, size.cols / step};
  }
  reduced.json = json_text(header);
  return reduced;
}

}  // namespace ovws::web
