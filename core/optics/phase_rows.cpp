#include "core/optics/phase_rows.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace ovws {
namespace {

using Lanes = std::array<double, kPhaseLanes>;

/// Bound on the rounding error, in units of the last place of the sum of magnitudes that cancel.
/// The errors of the terms are random: tilts reach half of this bound, higher orders less.
constexpr double kRoundings = 2.0;
constexpr double kRoundoff = 0x1p-53;
constexpr double kMaxErrorGain =
    0x1p33;                    ///< times a difference's rounding error (2^-65 waves): 2^-32 waves
constexpr int kMinSteps = 16;  ///< of a segment; fewer do not repay its initial differences
/// Segments begin at multiples of this many steps, which bounds the excess to the left of a row's
/// columns.
constexpr int kGrain = 4;

/// Error amplification: how often the last bits of the initial differences enter the last step.
double error_gain(int degree, int steps) {
  double sum = 0.0;
  double ways = 1.0;  // to choose k of the steps
  for (int k = 0; k <= degree; ++k) {
    sum += ways;
    ways = ways * (steps - k) / (k + 1);
  }
  return sum;
}

}  // namespace

std::uint16_t phase16(double waves) {
  // Adding 1.5 * 2^52 leaves the rounded integer in the double's low bits, without a branch and
  // without an undefined conversion.
  constexpr double kRounder = 6755399441055744.0;
  return static_cast<std::uint16_t>(std::bit_cast<std::uint64_t>(waves * 65536.0 + kRounder));
}

PhaseRows::PhaseRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px, int width,
                     int height)
    : modes_(modes, centre_px, diameter_px),
      diameter_px_(diameter_px),
      width_(width),
      height_(height),
      degree_(static_cast<int>(modes_.terms().size()) - 1),
      steps_(max_segment_steps()) {
  columns_.reserve(height);
  for (int y = 0; y < height; ++y) {
    columns_.push_back(columns_in_circle(centre_px, diameter_px, y, width));
  }
  if (in_fixed_point()) add_segments();
}

/// The steps that cover the columns, from a multiple of kGrain on.
Columns PhaseRows::steps_of(Columns columns) const {
  return {columns.begin / (kGrain * kPhaseLanes) * kGrain,
          (columns.end + kPhaseLanes - 1) / kPhaseLanes};
}

/// Bound on the sum of magnitudes that cancel when differences are summed, over the part of the
/// pupil's bounding square on the grid.
double PhaseRows::largest_terms(int steps) const {
  const Vec2 first = modes_.in_pupil({0.0, 0.0});
  const Vec2 last = modes_.in_pupil({width_ - 1.0, height_ - 1.0});
  const double beside = (steps + kGrain) * kPhaseLanes / modes_.radius_px();
  const double x = std::min(1.0, std::max(std::abs(first.x), std::abs(last.x))) + beside;
  const double y = std::min(1.0, std::max(std::abs(first.y), std::abs(last.y)));
  double sum = 0.0;
  double x_power = 1.0;
  for (const std::vector<double>& in_y : modes_.terms()) {
    double y_power = 1.0;
    for (const double term : in_y) {
      sum += std::abs(term) * x_power * y_power;
      y_power *= y;
    }
    x_power *= x;
  }
  return sum;
}

int PhaseRows::max_segment_steps() const {
  const int across = static_cast<int>(diameter_px_) / kPhaseLanes + 2 + kGrain;
  const int all = std::min(all_steps(), across);
  for (int parts = 1;; ++parts) {
    const int steps = ((all + parts - 1) / parts + kGrain - 1) / kGrain * kGrain;
    if (parts > 1 && steps < kMinSteps) return 0;
    if (error_gain(degree_, steps) > kMaxErrorGain) continue;
    if (kRoundings * kRoundoff * largest_terms(steps) <= kPhaseError) return steps;
  }
}

void PhaseRows::add_segments() {
  segments_.assign(all_steps() / kGrain + 1, -1);
  int count = 0;
  for (const Columns& in_pupil : columns_) {
    const Columns steps = steps_of(in_pupil);
    for (int first = steps.begin; first < steps.end; first += steps_) {
      int& segment = segments_[first / kGrain];
      if (segment >= 0) continue;
      segment = count++;
      add_segment(first * kPhaseLanes);
    }
  }
}

/// Newton form of the polynomial in x at each lane's first pixels, by repeated synthetic division.
/// Differencing values instead would suffer from cancellation.
void PhaseRows::add_segment(int first_x) {
  const int n = degree_;
  std::vector<std::vector<Lanes>> q;
  for (const std::vector<double>& in_y : modes_.terms()) {
    auto& lanes = q.emplace_back(in_y.size());
    for (std::size_t b = 0; b < in_y.size(); ++b) lanes[b].fill(in_y[b]);
  }
  for (int i = 0; i < n; ++i) {
    Lanes node;
    for (int l = 0; l < kPhaseLanes; ++l) {
      node[l] = modes_.in_pupil({static_cast<double>(first_x + l + i * kPhaseLanes), 0.0}).x;
    }
    for (int a = n - 1; a >= i; --a) {
      for (std::size_t b = 0; b < q[a + 1].size(); ++b) {
        for (int l = 0; l < kPhaseLanes; ++l) q[a][b][l] += node[l] * q[a + 1][b][l];
      }
    }
  }
  const double step = kPhaseLanes / modes_.radius_px();
  double scale = 1.0;  // k! step^k
  for (int k = 0; k <= n; ++k) {
    for (const Lanes& lanes : q[k]) {
      for (const double term : lanes) terms_.push_back(scale * term);
    }
    scale *= (k + 1) * step;
  }
}

std::size_t PhaseRows::row_size() const {
  return static_cast<std::size_t>(all_steps() + kSpareSteps) * kPhaseLanes;
}

Columns PhaseRows::row(int y, const HologramRowKernels& kernels, std::span<std::uint16_t> phase,
                       std::span<double> waves) const {
  const Columns in_pupil = columns_[y];
  if (in_pupil.begin >= in_pupil.end) return in_pupil;
  if (!in_fixed_point()) {
    const std::span<double> shown = waves.first(in_pupil.end - in_pupil.begin);
    modes_.waves(y, in_pupil.begin, shown);
    for (std::size_t k = 0; k < shown.size(); ++k) phase[in_pupil.begin + k] = phase16(shown[k]);
    return in_pupil;
  }
  const double y_in_pupil = modes_.in_pupil({0.0, static_cast<double>(y)}).y;
  const std::size_t length = (degree_ + 1) * (degree_ + 2) / 2 * kPhaseLanes;
  const Columns steps = steps_of(in_pupil);
  for (int first = steps.begin; first < steps.end; first += steps_) {
    kernels.phases(&terms_[length * segments_[first / kGrain]], degree_, y_in_pupil,
                   std::min(steps_, steps.end - first), phase.data() + first * kPhaseLanes);
  }
  return in_pupil;
}

}  // namespace ovws
