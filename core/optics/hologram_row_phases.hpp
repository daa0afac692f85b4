/// The phase of a sum of modes, row by row, rounded to 16 bits: by forward differences in fixed
/// point, where wrapping is free.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/optics/circle_columns.hpp"
#include "core/optics/hologram_row.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {

/// How near to a tie, in waves, a pixel may be rounded to the wrong side: 1/1024 of a step of the
/// 16-bit phase.
constexpr double kPhaseError = 1.0 / 65536.0 / 1024.0;

/// Immutable after construction, which takes microseconds.
class PhaseRows {
 public:
  /// Over the pixels of a `width x height` grid that lie in the pupil: the circle of `diameter_px`
  /// around `centre_px`. `modes` as WavefrontRows requires.
  PhaseRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px, int width, int height);

  /// Whether double precision resolves the differences of these modes, by a cautious estimate over
  /// the square around the pupil. If so `row` rounds the sum to the nearest 1/65536 wave, but may
  /// err within kPhaseError of a tie; otherwise it rounds what WavefrontRows makes of it.
  bool in_fixed_point() const { return steps_ > 0; }

  /// Elements that `row` needs to write to: width and some more.
  std::size_t row_size() const;
  /// The phase of row y, 2 pi = 65536, in the columns that are returned: those of the pupil.
  /// `phase[x]` belongs to column x; elements beside the columns are spoilt. `waves`: `width`
  /// elements of working memory. The same with any of the kernels.
  Columns row(int y, const HologramRowKernels& kernels, std::span<std::uint16_t> phase,
              std::span<double> waves) const;

 private:
  int all_steps() const { return (width_ + kPhaseLanes - 1) / kPhaseLanes; }
  Columns steps_of(Columns columns) const;
  double largest_terms(int steps) const;
  int longest_stretch() const;
  void add_stretches();
  void add_stretch(int first_x);

  WavefrontRows modes_;
  double diameter_px_;
  int width_;
  int height_;
  int degree_;
  int steps_ = 0;                 ///< of the longest stretch; 0: not in fixed point
  std::vector<Columns> columns_;  ///< of each row, in the pupil
  std::vector<double> terms_;     ///< of HologramRowKernels::phases, stretch after stretch
  std::vector<int> stretches_;    ///< which of them begins at each kGrain steps; -1: none
};

/// Waves to 16-bit phase, to the nearest 1/65536 (a tie to the even one); whole waves overflow
/// away. Defined, if meaningless, however large the value.
std::uint16_t phase16(double waves);

}  // namespace ovws
