#include "core/tracking/matched.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/pixels.hpp"
#include "core/tracking/matched_fit.hpp"
#include "core/tracking/patch.hpp"
#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

constexpr double kCapture = 1.0;                     // lambda/d
constexpr double kSearch = 0.8, kSearchStep = 0.26;  // lambda/d
constexpr int kBlock = 16;  // constant length of an inner loop, so that the compiler vectorises it

/// Whether the image holds every pixel within `margin` of `at`.
bool holds(const ImageView& image, Vec2 at, double margin) {
  return at.x - margin >= 0.0 && at.y - margin >= 0.0 && at.x + margin <= image.width - 1.0 &&
         at.y + margin <= image.height - 1.0;
}

std::vector<Vec2> search_shifts(double lambda_d_px) {
  const int reach = int(std::lround(kSearch / kSearchStep));
  std::vector<Vec2> shifts;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (x * x + y * y > reach * reach) continue;
      shifts.push_back(kSearchStep * lambda_d_px * Vec2{double(x), double(y)});
    }
  }
  return shifts;
}

/// Layout of the binned patch for the coarse search, with room for every shifted window.
struct Coarse {
  Coarse(const TemplateBank& bank, double reach_px)
      : bin(bank.bin()),
        columns(bank.coarse()->columns()),
        rows(bank.coarse()->rows()),
        reach(int(std::ceil(reach_px / bin))),
        half(rows / 2 + reach),
        stride(columns + 2 * reach),
        side_px((2 * half + 1) * bin) {}

  int bin;
  int columns, rows;  ///< of a window
  int reach;          ///< of the search, in bins
  int half;           ///< of the rows, and of the columns that hold pixels, in bins
  int stride;
  int side_px;
  std::size_t window() const { return std::size_t(columns) * std::size_t(rows); }
  std::size_t patch() const { return std::size_t(stride) * std::size_t(2 * half + 1); }
};

template <class T>
void add(const T* __restrict pixels, int count, float* __restrict line) {
  int x = 0;
  for (; x + kBlock <= count; x += kBlock) {
    for (int i = 0; i < kBlock; ++i) line[x + i] += float(pixels[x + i]);
  }
  for (; x < count; ++x) line[x] += float(pixels[x]);
}

/// Adds one image row to `line`. Pixels outside the image repeat its edge.
void add_row(const ImageView& image, int left, int y, int count, float* line) {
  const int row = std::clamp(y, 0, image.height - 1);
  const int first = std::clamp(left, 0, image.width - 1);
  const int last = std::clamp(left + count - 1, 0, image.width - 1);
  const auto place = [&](int x) { return std::clamp(x - left, 0, count - 1); };
  visit_rows(image, first, row, last - first + 1, 1, [&](int x, int, const auto* pixels, int n) {
    add(pixels, n, line + place(x));
    for (int k = 0; x == first && k < place(first); ++k) line[k] += float(pixels[0]);
    if (x + n - 1 != last) return;
    for (int k = place(last) + 1; k < count; ++k) line[k] += float(pixels[n - 1]);
  });
}

/// Bins pixels (sums of bin x bin) minus the first bin's sum. The offset keeps sums of a small spot
/// on a high background precise.
void bin_pixels(const ImageView& image, const Coarse& grid, int left, int top, float* line,
                float* patch) {
  float* out = patch + (grid.stride / 2 - grid.half);
  std::fill(patch, patch + grid.patch(), 0.0F);
  float offset = 0.0F;
  for (int r = 0; r <= 2 * grid.half; ++r, out += grid.stride) {
    std::fill(line, line + grid.side_px, 0.0F);
    for (int k = 0; k < grid.bin; ++k) {
      add_row(image, left, top + r * grid.bin + k, grid.side_px, line);
    }
    for (int c = 0; c <= 2 * grid.half; ++c) {
      float sum = 0.0F;
      for (int k = 0; k < grid.bin; ++k) sum += line[c * grid.bin + k];
      if (r == 0 && c == 0) offset = sum;
      out[c] = sum - offset;
    }
  }
}

float amplitude(const TemplateBank& coarse, const TemplateKernels& kernels, const float* window) {
  const TemplateBank::Place unshifted;
  const TemplateMoments m = kernels.moments(coarse.view(unshifted, kMiddleNoise), window);
  const auto& c = coarse.solver(unshifted, kMiddleNoise).inverse;
  return c[4] * m.one + c[5] * m.value + c[6] * m.cx + c[7] * m.cy;
}

/// Floats of scratch.samples and of scratch.sums that coarse_start needs.
std::size_t coarse_samples(const TemplateBank& bank, double reach_px) {
  if (!bank.coarse()) return 0;
  const Coarse grid(bank, reach_px);
  return grid.window() + grid.patch();
}

std::size_t coarse_sums(const TemplateBank& bank, double reach_px) {
  return bank.coarse() ? std::size_t(Coarse(bank, reach_px).side_px) : 0;
}

/// Grid search on binned pixels: the position within about `reach_px` of `start` where the bank's
/// template has the largest amplitude, in steps of one bin. The pixels are read once, however large
/// the spot is. None if no amplitude is positive.
std::optional<Vec2> coarse_start(const TemplateBank& bank, const TemplateKernels& kernels,
                                 const ImageView& image, Vec2 start, double reach_px,
                                 TrackScratch& scratch) {
  const Coarse grid(bank, reach_px);
  float* window = scratch.samples.data();
  float* patch = window + grid.window();
  const int x = int(std::lround(start.x)) - grid.bin / 2;  // the middle bin's first pixel
  const int y = int(std::lround(start.y)) - grid.bin / 2;
  bin_pixels(image, grid, x - grid.half * grid.bin, y - grid.half * grid.bin, scratch.sums.data(),
             patch);
  const Vec2 middle = Vec2{double(x), double(y)} + 0.5 * double(grid.bin - 1) * Vec2{1.0, 1.0};
  std::optional<Vec2> best;
  float best_score = 0.0F;
  for (int dy = -grid.reach; dy <= grid.reach; ++dy) {
    for (int dx = -grid.reach; dx <= grid.reach; ++dx) {
      if (dx * dx + dy * dy > grid.reach * grid.reach) continue;
      const float* from = patch + (grid.reach + dy) * grid.stride + grid.reach + dx;
      for (int r = 0; r < grid.rows; ++r, from += grid.stride) {
        std::copy(from, from + grid.columns, window + r * grid.columns);
      }
      const float score = amplitude(*bank.coarse(), kernels, window);
      if (!(score > best_score)) continue;
      best_score = score;
      best = middle + double(grid.bin) * Vec2{double(dx), double(dy)};
    }
  }
  return best;
}

}  // namespace

MatchedTracker::MatchedTracker(const SpotModel& spots) : MatchedTracker(spots, {}) {}

MatchedTracker::MatchedTracker(const SpotModel& spots,
                               std::vector<std::shared_ptr<const TemplateBank>> own)
    : spots_(spots),
      model_(std::make_shared<TemplateBank>(
          spots, ModelShape(spots, 1.5 * matched_window(spots.charge) + 1.0))),
      own_(std::move(own)),
      kernels_(template_kernels().back()),
      search_(search_shifts(spots.lambda_d_px)),
      half_(int(std::ceil(kCapture * spots.lambda_d_px)) + model_->columns() / 2),
      spot_half_px_(spot_geometry(spots.charge).ring_outer * spots.lambda_d_px) {}

TrackScratch MatchedTracker::make_scratch() const {
  const double reach_px = kSearch * spots_.lambda_d_px;
  std::size_t samples = 0, sums = 0;
  const auto make_room = [&](const TemplateBank& bank) {
    const auto columns = std::size_t(bank.columns()), rows = std::size_t(bank.rows());
    samples = std::max({samples, columns * rows, coarse_samples(bank, reach_px)});
    sums = std::max({sums, columns, coarse_sums(bank, reach_px)});
  };
  make_room(*model_);
  for (const auto& bank : own_) {
    if (bank) make_room(*bank);
  }
  return {std::vector<float>(samples), std::vector<float>(sums)};
}

const TemplateBank& MatchedTracker::bank_of(int spot) const {
  const bool own = spot >= 0 && std::size_t(spot) < own_.size() && own_[std::size_t(spot)];
  return own ? *own_[std::size_t(spot)] : *model_;
}

std::optional<Vec2> MatchedTracker::fine_start(MatchedFit& fit, Vec2 start) const {
  std::optional<Vec2> best;
  double best_score = 0.0;
  for (const Vec2 shift : search_) {
    const double score = fit.score(start + shift);
    if (score > best_score) best = start + shift;
    best_score = std::max(best_score, score);
  }
  return best;
}

SpotFix MatchedTracker::track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                              int spot) const {
  SpotFix fix;
  if (!holds(image, start_px, 0.0)) return fix;  // also rejects NaN
  const TemplateBank& bank = bank_of(spot);
  const double reach_px = kCapture * spots_.lambda_d_px;
  MatchedFit fit(bank, kernels_, image, spots_, scratch);
  const auto found = [&](Vec2 from) {
    if (!fit.follow(from, start_px, reach_px)) return false;
    const Vec2 at = fit.found();
    return norm(at - start_px) <= reach_px && holds(image, at, spot_half_px_) && fit.is_spot();
  };
  bool good = found(start_px);
  if (!good) {
    const std::optional<Vec2> best =
        bank.coarse()
            ? coarse_start(bank, kernels_, image, start_px, kSearch * spots_.lambda_d_px, scratch)
            : fine_start(fit, start_px);
    fit.invalidate_window();  // the search has overwritten it
    good = best && found(*best);
  }
  const Vec2 at = good ? fit.found() : start_px;
  fix.peak = brightest_pixel(image, at, int(std::ceil(spot_half_px_)));
  if (!good) return fix;
  fix.x = float(at.x);
  fix.y = float(at.y);
  fix.quality = float(fit.quality());
  fix.level = float(fit.amplitude()) * bank.mean_bright();
  fix.noise = float(fit.noise());
  return fix;
}

}  // namespace ovws
