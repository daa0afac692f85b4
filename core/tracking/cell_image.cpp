#include "core/tracking/cell_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ovws {
namespace {

constexpr double kSigmaPerMedianDeviation = 1.4826;  // of a normal distribution

template <class T>
void average(const ImageView& image, int bin, Eigen::MatrixXf& out) {
  out.setZero();
  for (int y = 0; y < int(out.rows()) * bin; ++y) {
    const T* row = image.row<T>(y);
    for (int x = 0; x < int(out.cols()) * bin; ++x) out(y / bin, x / bin) += float(row[x]);
  }
  out /= float(bin * bin);
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

CellImage average_cells(const ImageView& image, int bin) {
  CellImage cells;
  cells.bin = bin;
  cells.light.resize(image.height / bin, image.width / bin);
  if (bytes_per_pixel(image.format) == 1) {
    average<std::uint8_t>(image, bin, cells.light);
  } else {
    average<std::uint16_t>(image, bin, cells.light);
  }
  std::vector<float> values(cells.light.data(), cells.light.data() + cells.light.size());
  cells.light.array() -= median(values);
  for (Eigen::Index k = 0; k < cells.light.size(); ++k) {
    values[std::size_t(k)] = std::abs(cells.light.data()[k]);
  }
  // Rounding to whole DN is noise too, and all that a noise-free image has.
  constexpr double kRounding = 0.29;
  cells.noise = std::max(kRounding / bin, kSigmaPerMedianDeviation * double(median(values)));
  return cells;
}

}  // namespace ovws
