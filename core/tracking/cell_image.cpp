#include "core/tracking/cell_image.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

constexpr double kSigmaPerMedianDeviation = 1.4826;  // of a normal distribution

void average(const ImageView& image, int bin, Eigen::MatrixXf& out) {
  out.setZero();
  visit_rows(image, 0, 0, int(out.cols()) * bin, int(out.rows()) * bin,
             [&](int x, int y, const auto* pixels, int count) {
               for (int i = 0; i < count; ++i) out(y / bin, (x + i) / bin) += float(pixels[i]);
             });
  out /= float(bin * bin);
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

CellImage average_cells(const ImageView& image, const ColourPlane& plane, int bin) {
  CellImage cells;
  cells.bin = bin;
  cells.plane = plane;
  const ImageView lit = on_plane(image, plane);
  cells.light.resize(lit.height / bin, lit.width / bin);
  average(lit, bin, cells.light);
  std::vector<float> values(cells.light.data(), cells.light.data() + cells.light.size());
  cells.light.array() -= median(values);
  for (Eigen::Index k = 0; k < cells.light.size(); ++k) {
    values[std::size_t(k)] = std::abs(cells.light.data()[k]);
  }
  // Rounding to whole DN is the only noise of a noise-free image.
  constexpr double kRounding = 0.29;
  cells.noise = std::max(kRounding / bin, kSigmaPerMedianDeviation * double(median(values)));
  return cells;
}

bool is_other_image(const CellImage& before, const CellImage& now) {
  constexpr double kOther = 0.02;   // of the contrast's energy
  constexpr double kOfNoise = 1.5;  // bright bins are noisier than dark ones
  const Eigen::MatrixXf &a = before.light, &b = now.light;
  if (a.rows() != b.rows() || a.cols() != b.cols()) return true;
  const auto cells = double(a.size());
  const double noise = kOfNoise * cells * (before.noise * before.noise + now.noise * now.noise);
  const double energy = 0.5 * double(a.squaredNorm() + b.squaredNorm());
  return double((a - b).squaredNorm()) - noise > kOther * std::max(energy - 0.5 * noise, 0.0);
}

}  // namespace ovws
