#include "core/tracking/binned_image.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/median.hpp"
#include "core/base/pixels.hpp"

namespace ovws {
namespace {

void average(const ImageView& image, int bin, Eigen::MatrixXf& out) {
  out.setZero();
  visit_rows(image, 0, 0, int(out.cols()) * bin, int(out.rows()) * bin,
             [&](int x, int y, const auto* pixels, int count) {
               for (int i = 0; i < count; ++i) out(y / bin, (x + i) / bin) += float(pixels[i]);
             });
  out /= float(bin * bin);
}

}  // namespace

BinnedImage binned(const ImageView& image, const ColourPlane& plane, int bin) {
  BinnedImage out;
  out.bin = bin;
  out.plane = plane;
  const ImageView lit = on_plane(image, plane);
  out.intensity.resize(lit.height / bin, lit.width / bin);
  average(lit, bin, out.intensity);
  std::vector<float> values(out.intensity.data(), out.intensity.data() + out.intensity.size());
  out.intensity.array() -= median(values);
  for (Eigen::Index k = 0; k < out.intensity.size(); ++k) {
    values[std::size_t(k)] = std::abs(out.intensity.data()[k]);
  }
  // Rounding to whole DN (RMS 1/sqrt(12)) is the only noise of a noise-free image.
  constexpr double kRounding = 0.29;
  out.noise = std::max(kRounding / bin, kSigmaPerMedianDeviation * double(median(values)));
  return out;
}

bool is_other_image(const BinnedImage& before, const BinnedImage& now) {
  constexpr double kOther = 0.02;   // share of the contrast energy
  constexpr double kOfNoise = 1.5;  // on the noise: bright bins are noisier than dark bins
  const Eigen::MatrixXf &a = before.intensity, &b = now.intensity;
  if (a.rows() != b.rows() || a.cols() != b.cols()) return true;
  const auto bins = double(a.size());
  const double noise = kOfNoise * bins * (before.noise * before.noise + now.noise * now.noise);
  const double energy = 0.5 * double(a.squaredNorm() + b.squaredNorm());
  return double((a - b).squaredNorm()) - noise > kOther * std::max(energy - 0.5 * noise, 0.0);
}

}  // namespace ovws
