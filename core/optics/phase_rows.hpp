/// Phase of a sum of Zernike modes by fixed-point forward differences, row by row, rounded to 16
/// bits. Integer overflow wraps the phase at no cost.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/optics/circle_columns.hpp"
#include "core/optics/hologram_row.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {

/// Maximum phase error before rounding, in waves: 1/1024 of a step of the 16-bit phase. Only pixels
/// closer than this to a tie may round to the wrong side.
constexpr double kPhaseError = 1.0 / 65536.0 / 1024.0;

/// Immutable after construction, which takes microseconds.
class PhaseRows {
 public:
  /// For the pixels of a `width x height` grid inside the pupil, the circle of `diameter_px` about
  /// `centre_px`. Requires valid mode indices, as WavefrontRows does.
  PhaseRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px, int width, int height);

  /// True: `row` adds forward differences in fixed point. Their error is at most kPhaseError by a
  /// conservative estimate over the pupil's bounding square, so the phase is the nearest 1/65536
  /// wave, except within kPhaseError of a tie. False: `row` rounds the result of WavefrontRows.
  bool in_fixed_point() const { return steps_ > 0; }

  /// Number of elements that `row` may write: `width` plus padding.
  std::size_t row_size() const;
  /// Computes row y as 16-bit phase (65536 = 2 pi) and returns the pupil's columns. `phase[x]`
  /// belongs to column x; elements outside the columns may be overwritten with garbage.
  /// `waves`: working memory of `width` elements. All kernels give the same result.
  Columns row(int y, const HologramRowKernels& kernels, std::span<std::uint16_t> phase,
              std::span<double> waves) const;

 private:
  int all_steps() const { return (width_ + kPhaseLanes - 1) / kPhaseLanes; }
  Columns steps_of(Columns columns) const;
  double largest_terms(int steps) const;
  int max_segment_steps() const;
  void add_segments();
  void add_segment(int first_x);

  WavefrontRows modes_;
  double diameter_px_;
  int width_;
  int height_;
  int degree_;
  int steps_ = 0;                 ///< maximum segment length; 0: not in fixed point
  std::vector<Columns> columns_;  ///< the pupil's columns in each row
  std::vector<double> terms_;     ///< for HologramRowKernels::phases, segment after segment
  std::vector<int> segments_;  ///< index of the segment that begins at each kGrain steps; -1: none
};

/// Converts waves to 16-bit phase: rounds to the nearest 1/65536 wave (ties to even) and drops
/// whole waves. Never undefined behaviour, but meaningless for very large values.
std::uint16_t phase16(double waves);

}  // namespace ovws
