#include "core/tracking/candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/pixels.hpp"
#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

constexpr double kGridPerLambdaD = 3.2;
// In units of the first dark ring's radius: reach of the correlation, minimum distance of spots.
constexpr double kReach = 1.1;
constexpr double kMinDistance = 0.6;
static_assert(kMinDistance < kReach);          // the neighbourhood of a peak lies inside the margin
constexpr std::size_t kPeaksPerCandidate = 4;  // leaves room for a broad spot's side maxima

int bin_px(const SpotModel& spots) {
  return std::max(1, int(std::lround(spots.on_plane().lambda_d_px / kGridPerLambdaD)));
}

int padded(int pixels, int bin, int margin) {
  return (pixels + bin - 1) / bin + 2 * margin;
}

}  // namespace

CandidateFinder::CandidateFinder(const SpotModel& spots, int image_width, int image_height,
                                 Most most)
    : plane_(spots.lit.plane), bin_(bin_px(spots)), most_(most) {
  const double dark = spot_geometry(spots.charge).dark;
  const double unit = spots.on_plane().lambda_d_px / bin_;  // lambda/d in bins
  const double reach = kReach * dark * unit;
  margin_ = int(std::ceil(reach));
  min_distance_ = kMinDistance * dark * unit;
  double sum = 0.0;
  for (int dy = -margin_; dy <= margin_; ++dy) {
    for (int dx = -margin_; dx <= margin_; ++dx) {
      const double r = std::hypot(dx, dy);
      if (r > reach) continue;
      taps_.push_back({dx, dy, float(spot_intensity(spots.charge, r / unit))});
      sum += double(taps_.back().weight);
    }
  }
  for (Tap& tap : taps_) tap.weight -= float(sum / double(taps_.size()));
  const int near = int(std::ceil(min_distance_));
  for (int dy = -near; dy <= near; ++dy) {
    for (int dx = -near; dx <= near; ++dx) {
      if (std::hypot(dx, dy) < min_distance_) near_offsets_.push_back({dx, dy, 0.0F});
    }
  }
  const int columns = padded(plane_.count(image_width, plane_.x), bin_, margin_);
  const int rows = padded(plane_.count(image_height, plane_.y), bin_, margin_);
  grid_ = Grid::Zero(rows, columns);
  score_ = Grid::Zero(rows, columns);
  suppressed_ = Mask::Constant(rows, columns, false);
  near_peaks_.reserve(kPeaksPerCandidate * std::size_t(most.near));
  other_peaks_.reserve(kPeaksPerCandidate * std::size_t(most.elsewhere));
  peaks_.reserve(near_peaks_.capacity() + other_peaks_.capacity());
  candidates_.reserve(std::size_t(most.near + most.elsewhere));
}

std::span<const Vec2> CandidateFinder::find(const ImageView& image, const Parts& parts) {
  average(on_plane(image, plane_));
  correlate();
  collect_peaks(parts);
  suppress_neighbours();
  return candidates_;
}

/// Averages the pixels of one row of bins, in runs of at most kPixelRun pixels, because images are
/// unpacked in runs.
void CandidateFinder::add_row(const ImageView& image, Eigen::Index row, int top, int bottom) {
  const int stride = std::max(1, kPixelRun / bin_) * bin_;
  std::array<unsigned, kPixelRun> sums;
  for (int left = 0; left < image.width; left += stride) {
    const int columns = std::min(stride, image.width - left);
    sums.fill(0);
    visit_rows(image, left, top, columns, bottom - top,
               [&](int, int, const auto* pixels, int count) {
                 unsigned* sum = sums.data();
                 for (int x = 0; x < count; x += bin_, ++sum) {
                   for (int i = x; i < std::min(x + bin_, count); ++i) *sum += pixels[i];
                 }
               });
    for (int x = 0; x < columns; x += bin_) {
      grid_(row, margin_ + (left + x) / bin_) =
          float(sums[std::size_t(x / bin_)]) / float((bottom - top) * std::min(bin_, columns - x));
    }
  }
}

void CandidateFinder::average(const ImageView& image) {
  const int columns = int(grid_.cols()), rows = int(grid_.rows());
  const int last_column = columns - margin_ - 1, last_row = rows - margin_ - 1;
  for (int r = margin_; r <= last_row; ++r) {
    const int top = (r - margin_) * bin_, bottom = std::min(top + bin_, image.height);
    add_row(image, r, top, bottom);
    grid_.row(r).head(margin_).setConstant(grid_(r, margin_));
    grid_.row(r).tail(margin_).setConstant(grid_(r, last_column));
  }
  for (int r = 0; r < margin_; ++r) {
    grid_.row(r) = grid_.row(margin_);
    grid_.row(rows - 1 - r) = grid_.row(last_row);
  }
}

void CandidateFinder::correlate() {
  const Eigen::Index inner = grid_.cols() - 2 * Eigen::Index(margin_);
  for (Eigen::Index r = margin_; r < grid_.rows() - margin_; ++r) {
    if (inner < kStrip) {
      correlate_strip<Eigen::Dynamic>(r, 0, inner);
      continue;
    }
    for (Eigen::Index c = 0; c < inner; c += kStrip) {
      c = std::min(c, inner - kStrip);  // the last strip may overlap the previous one
      correlate_strip<kStrip>(r, c, kStrip);
    }
  }
}

/// Correlates a strip of `count` columns that begins `first` columns after the margin. The strip is
/// narrow, so that its sums stay in CPU registers.
template <int kCount>
void CandidateFinder::correlate_strip(Eigen::Index row, Eigen::Index first, Eigen::Index count) {
  Eigen::Array<float, 1, kCount, Eigen::RowMajor, 1, kStrip> sum;
  sum.setZero(count);
  for (const Tap& tap : taps_) {
    sum += tap.weight *
           grid_.row(row + tap.dy).template segment<kCount>(margin_ + first + tap.dx, count);
  }
  score_.row(row).template segment<kCount>(margin_ + first, count) = sum;
}

/// Camera pixel in the middle of a bin of the grid.
Vec2 CandidateFinder::place_of(int column, int row) const {
  return plane_.to_image(
      {bin_ * (column - margin_ + 0.5) - 0.5, bin_ * (row - margin_ + 0.5) - 0.5});
}

/// Adds a peak to a heap of constant size, in place of its worst one.
void CandidateFinder::keep_best(const Peak& peak, std::vector<Peak>& heap) {
  if (heap.size() == heap.capacity()) {
    if (heap.empty() || peak.score <= heap.front().score) return;  // the worst one is in front
    std::pop_heap(heap.begin(), heap.end(), better);
    heap.pop_back();
  }
  heap.push_back(peak);
  std::push_heap(heap.begin(), heap.end(), better);
}

// The border of score_ stays 0, so that maxima at the image's edge count too.
void CandidateFinder::collect_peaks(const Parts& parts) {
  near_peaks_.clear();
  other_peaks_.clear();
  for (int r = margin_; r < score_.rows() - margin_; ++r) {
    for (int c = margin_; c < score_.cols() - margin_; ++c) {
      const float score = score_(r, c);
      if (!(score > 0.0F) || score < score_.block<3, 3>(r - 1, c - 1).maxCoeff()) continue;
      const Vec2 place = place_of(c, r);
      if (parts.within && !parts.within->contains(place)) continue;
      const bool near = parts.near && parts.near->contains(place);
      keep_best({score, c, r, near}, near ? near_peaks_ : other_peaks_);
    }
  }
  std::sort(near_peaks_.begin(), near_peaks_.end(), better);
  std::sort(other_peaks_.begin(), other_peaks_.end(), better);
  peaks_.resize(near_peaks_.size() + other_peaks_.size());  // within the reserved capacity
  std::merge(near_peaks_.begin(), near_peaks_.end(), other_peaks_.begin(), other_peaks_.end(),
             peaks_.begin(), better);
}

void CandidateFinder::suppress_neighbours() {
  candidates_.clear();
  suppressed_.setConstant(false);
  Most left = most_;
  for (const Peak& peak : peaks_) {
    int& places = peak.near ? left.near : left.elsewhere;
    if (places == 0 || suppressed_(peak.row, peak.column)) continue;
    for (const Tap& by : near_offsets_) suppressed_(peak.row + by.dy, peak.column + by.dx) = true;
    candidates_.push_back(place_of(peak.column, peak.row));
    --places;
  }
}

}  // namespace ovws
