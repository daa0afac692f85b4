#include "drivers/twin/pupil_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/complex_product.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/phasors.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws::twin {
namespace {

constexpr int kBlocksAcross = 96;
constexpr double kMinAmplitudeShare = 0.25;

}  // namespace

PupilBlocks::PupilBlocks(Image<float> amplitude, Vec2 centre_px, double diameter_px)
    : amplitude_(std::move(amplitude)),
      centre_px_(centre_px),
      diameter_px_(diameter_px),
      step_px_(std::max(1, int(diameter_px / kBlocksAcross))),
      first_x_px_(int(std::floor(centre_px.x - diameter_px / 2))),
      first_y_px_(int(std::floor(centre_px.y - diameter_px / 2))),
      across_(int(diameter_px / step_px_) + 2),
      number_(std::size_t(across_) * std::size_t(across_), -1) {
  place_blocks();
}

void PupilBlocks::place_blocks() {
  struct Sum {
    double amplitude = 0.0;
    Vec2 at_px;
  };
  std::vector<Sum> sums(number_.size());
  for (int y = 0; y < amplitude_.height; ++y) {
    const Columns pupil = columns_in_circle(centre_px_, diameter_px_, y, amplitude_.width);
    for (int x = pupil.begin; x < pupil.end; ++x) {
      Sum& sum = sums[bin(x, y)];
      const double amplitude = amplitude_.at(x, y);
      sum.amplitude += amplitude;
      sum.at_px = sum.at_px + amplitude * Vec2{double(x), double(y)};
    }
  }
  double brightest = 0.0;
  for (const Sum& sum : sums) brightest = std::max(brightest, sum.amplitude);
  std::vector<Sum> kept;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].amplitude <= kMinAmplitudeShare * brightest) continue;
    number_[i] = int(kept.size());
    kept.push_back(sums[i]);
  }
  weights_.resize(Eigen::Index(kept.size()));
  modes_.resize(weights_.size(), kModes);
  for (Eigen::Index b = 0; b < weights_.size(); ++b) {
    const Sum& sum = kept[std::size_t(b)];
    const Vec2 at = (2.0 / diameter_px_) * ((1.0 / sum.amplitude) * sum.at_px - centre_px_);
    weights_[b] = sum.amplitude;
    for (int j = 0; j < kModes; ++j) modes_(b, j) = zernike(j, at);
  }
  join_neighbours();
}

void PupilBlocks::join_neighbours() {
  const auto across = std::size_t(across_);
  for (std::size_t i = 0; i < number_.size(); ++i) {
    if (number_[i] < 0) continue;
    const bool right = (i + 1) % across != 0 && number_[i + 1] >= 0;
    const bool below = i + across < number_.size() && number_[i + across] >= 0;
    if (right) neighbours_.emplace_back(number_[i], number_[i + 1]);
    if (below) neighbours_.emplace_back(number_[i], number_[i + across]);
  }
}

std::size_t PupilBlocks::bin(int x, int y) const {
  const int column = (x - first_x_px_) / step_px_, row = (y - first_y_px_) / step_px_;
  return std::size_t(row) * std::size_t(across_) + std::size_t(column);
}

Eigen::VectorXcd PupilBlocks::sums(const Image<std::complex<float>>* field,
                                   std::span<const Mode> modes) const {
  const std::vector<std::complex<float>>& phasors = unit_phasors();
  const WavefrontRows wavefront(modes, centre_px_, diameter_px_);
  std::vector<double> waves(std::size_t(amplitude_.width));
  Eigen::VectorXcd sums = Eigen::VectorXcd::Zero(weights_.size());
  for (int y = 0; y < amplitude_.height; ++y) {
    const Columns pupil = columns_in_circle(centre_px_, diameter_px_, y, amplitude_.width);
    if (pupil.begin == pupil.end) continue;
    wavefront.waves(y, pupil.begin, std::span(waves).subspan(pupil.begin, pupil.end - pupil.begin));
    for (int x = pupil.begin; x < pupil.end; ++x) {
      const int block = number_[bin(x, y)];
      if (block < 0) continue;
      const std::complex<float> conjugate = phasors[phase16(-waves[std::size_t(x)])];
      const std::complex<float> value = field ? field->at(x, y) : amplitude_.at(x, y);
      sums[block] += std::complex<double>(product(value, conjugate));
    }
  }
  return sums;
}

Eigen::VectorXcd PupilBlocks::smoothed(Eigen::VectorXcd sums) const {
  constexpr int kPasses = 3;
  constexpr double kShare = 0.125;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::VectorXcd before = sums;
    for (const auto& [a, b] : neighbours_) {
      const std::complex<double> flow = kShare * (before[a] - before[b]);
      sums[a] -= flow;
      sums[b] += flow;
    }
  }
  return sums;
}

}  // namespace ovws::twin
