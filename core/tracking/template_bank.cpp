#include "core/tracking/template_bank.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

constexpr double kWindowOfDark = 0.98, kMinWindow = 1.5;
// Half a step is the largest offset that the linearisation must bridge: 1/8 px at 12.55 px.
constexpr double kStepsPerLambdaD = 49.0;
constexpr double kBright = 0.25;           // of the template's maximum: pixels of the sectors
constexpr double kCoreOfRingInner = 0.45;  // radius of a vortex core's disc, as in SpotCheck
constexpr double kDarkCore = 0.2;          // largest mean of a dark core of the template
// Bin size of the coarse bank: a quarter of lambda/d; bins of 2 from 6 px on.
constexpr double kBinOfLambdaD = 0.24, kBinMore = 0.6;
constexpr double kMinPivot = 1e-5;  // of the normal matrix scaled to a unit diagonal

int steps_of(const SpotModel& spots) {
  return std::max(1, int(std::ceil(kStepsPerLambdaD / spots.lambda_d_px)));
}

int bin_of(const SpotModel& spots) {
  return std::max(1, int(kBinOfLambdaD * spots.lambda_d_px + kBinMore));
}

/// Another shape averaged over square bins, with lengths in bins.
class BinnedShape final : public SpotShape {
 public:
  BinnedShape(const SpotShape& shape, int bin) : shape_(shape), bin_(bin) {}

  ShapeSample at(Vec2 from_centre) const override {
    ShapeSample mean;
    for (int k = 0; k < bin_ * bin_; ++k) {
      const Vec2 off{k % bin_ - 0.5 * (bin_ - 1), k / bin_ - 0.5 * (bin_ - 1)};
      const ShapeSample sample = shape_.at(double(bin_) * from_centre + off);
      mean.value += sample.value / (bin_ * bin_);
      mean.dx += sample.dx / bin_;
      mean.dy += sample.dy / bin_;
    }
    return mean;
  }

 private:
  const SpotShape& shape_;
  int bin_;
};

int half_of(const SpotModel& spots) {
  return int(std::floor(matched_window(spots.charge) * spots.lambda_d_px + 0.5));
}

int whole_blocks(int count) {
  return (count + kTemplateBlock - 1) / kTemplateBlock * kTemplateBlock;
}

int floor_div(int a, int b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

}  // namespace

double matched_window(int charge) {
  return std::max(kMinWindow, kWindowOfDark * spot_geometry(charge).dark);
}

TemplateBank::TemplateBank(const SpotModel& spots, const SpotShape& shape)
    : TemplateBank(spots, shape, steps_of(spots)) {
  bin_ = bin_of(spots);
  if (bin_ < 2) return;
  const SpotModel binned{spots.charge, spots.lambda_d_px / bin_};
  coarse_.reset(new TemplateBank(binned, BinnedShape(shape, bin_), 1));
}

TemplateBank::TemplateBank(const SpotModel& spots, const SpotShape& shape, int steps)
    : steps_(steps),
      columns_(whole_blocks(2 * (half_of(spots) + 1))),
      rows_(2 * half_of(spots) + 1) {
  const int shifts = steps_ * steps_;
  const std::size_t blocks = std::size_t(columns_) * std::size_t(rows_) / kTemplateBlock;
  planes_.resize(blocks * std::size_t(3 + kLevels) * std::size_t(shifts));
  const double radius_px = matched_window(spots.charge) * spots.lambda_d_px;
  for (int shift = 0; shift < shifts; ++shift) {
    fill(shift, shape, radius_px);
    for (int level = 0; level < kLevels; ++level) {
      solvers_.push_back(solve(shift, level));
      regular_ = regular_ && solvers_.back().regular;
    }
  }
  find_parts(spots);
}

void TemplateBank::find_parts(const SpotModel& spots) {
  const double core_px =
      std::max(1.0, kCoreOfRingInner * spot_geometry(spots.charge).ring_inner * spots.lambda_d_px);
  const int unshifted = (steps_ / 2) * steps_ + steps_ / 2;
  const float *value = plane(unshifted, 0), *weight = plane(unshifted, 3);
  std::array<std::vector<int>, Parts::kSectors + 1> parts;
  std::array<double, Parts::kSectors> sums{};
  double bright = 0.0, core = 0.0;
  int count = 0;
  for (int k = 0; k < rows_ * columns_; ++k) {
    if (!(weight[k] > 0.0F)) continue;
    ++pixels_;
    const double t = double(value[k]), x = k % columns_ - columns_ / 2,
                 y = k / columns_ - rows_ / 2;
    if (spots.charge != 0 && std::hypot(x, y) <= core_px) {
      parts[Parts::kSectors].push_back(k);
      core += t;
    }
    if (t > 0.5) bright += t;
    if (t > 0.5) ++count;
    if (!(t > kBright)) continue;
    const double turn = std::atan2(y, x) / (2.0 * std::numbers::pi) + 1.0;
    const auto sector = std::size_t(std::lround(turn * Parts::kSectors)) % Parts::kSectors;
    parts[sector].push_back(k);
    sums[sector] += t;
  }
  if (core > kDarkCore * double(parts[Parts::kSectors].size())) parts[Parts::kSectors].clear();
  mean_bright_ = count > 0 ? float(bright / count) : 0.0F;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts_.offsets.insert(parts_.offsets.end(), parts[i].begin(), parts[i].end());
    parts_.begin[i + 1] = int(parts_.offsets.size());
    if (i < sums.size())
      parts_.value[i] = float(sums[i] / double(std::max<std::size_t>(1, parts[i].size())));
  }
}

float* TemplateBank::plane(int shift, int k) {
  const std::size_t blocks = std::size_t(columns_) * std::size_t(rows_) / kTemplateBlock;
  return planes_[blocks * std::size_t(shift * (3 + kLevels) + k)].lane.data();
}

const float* TemplateBank::plane(int shift, int k) const {
  return const_cast<TemplateBank*>(this)->plane(shift, k);
}

void TemplateBank::fill(int shift, const SpotShape& shape, double radius_px) {
  const double first = -double(steps_ / 2) / steps_;
  const Vec2 centre{first + double(shift % steps_) / steps_,
                    first + double(shift / steps_) / steps_};
  float *value = plane(shift, 0), *cx = plane(shift, 1), *cy = plane(shift, 2);
  for (int k = 0; k < rows_ * columns_; ++k) {
    const Vec2 at = Vec2{double(k % columns_ - columns_ / 2), double(k / columns_ - rows_ / 2)};
    const ShapeSample sample = shape.at(at - centre);
    value[k] = float(sample.value);
    cx[k] = float(-sample.dx);
    cy[k] = float(-sample.dy);
    if (norm(at - centre) > radius_px) continue;
    for (int level = 0; level < kLevels; ++level) {
      plane(shift, 3 + level)[k] =
          float(1.0 / (kNoiseLevels[std::size_t(level)] + std::clamp(sample.value, 0.0, 1.0)));
    }
  }
}

TemplateBank::Solver TemplateBank::solve(int shift, int level) const {
  Solver s;
  const float *value = plane(shift, 0), *cx = plane(shift, 1), *cy = plane(shift, 2);
  const float* weight = plane(shift, 3 + level);
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (int k = 0; k < rows_ * columns_; ++k) {
    const double w = double(weight[k]), t = double(value[k]);
    if (!(w > 0.0)) continue;
    const Eigen::Vector4d basis(1.0, t, double(cx[k]), double(cy[k]));
    normal += w * basis * basis.transpose();
    s.ww += w * w;
    s.wwt += w * w * t;
    s.wwtt += w * w * t * t;
  }
  s.weight = normal(0, 0);
  s.contrast = normal(1, 1) - normal(0, 1) * normal(0, 1) / normal(0, 0);
  const Eigen::Vector4d scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return s;
  const Eigen::LDLT<Eigen::Matrix4d> scaled(scale.asDiagonal() * normal * scale.asDiagonal());
  if (!(scaled.vectorD().minCoeff() > kMinPivot)) return s;
  const Eigen::Matrix4d inverse =
      scale.asDiagonal() * scaled.solve(Eigen::Matrix4d::Identity()) * scale.asDiagonal();
  for (int i = 0; i < 16; ++i) s.inverse[std::size_t(i)] = float(inverse(i / 4, i % 4));
  s.regular = true;
  return s;
}

TemplateBank::Place TemplateBank::place(Vec2 at) const {
  const auto axis = [this](double c, int& pixel, double& centre) {
    const int nearest = int(std::lround(c * steps_));
    pixel = floor_div(nearest + steps_ / 2, steps_);
    centre = double(nearest) / steps_;
    return nearest - pixel * steps_ + steps_ / 2;
  };
  Place p;
  const int column = axis(at.x, p.x, p.centre.x);
  p.shift = axis(at.y, p.y, p.centre.y) * steps_ + column;
  return p;
}

TemplateView TemplateBank::view(const Place& place, int level) const {
  return {columns_,
          rows_,
          plane(place.shift, 0),
          plane(place.shift, 1),
          plane(place.shift, 2),
          plane(place.shift, 3 + level)};
}

const TemplateBank::Solver& TemplateBank::solver(const Place& place, int level) const {
  return solvers_[std::size_t(place.shift * kLevels + level)];
}

}  // namespace ovws
