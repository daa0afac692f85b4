/// Where in a whole image something like a spot may be.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Correlates the image, averaged to about three pixels per lambda/d, with the ideal spot less its
/// mean (flat light scores nothing), and keeps the best maxima that are no closer together than a
/// spot's radius. Memory for one image size, made off the frame path.
class CandidateFinder {
 public:
  CandidateFinder(const SpotModel& spots, int image_width, int image_height, int max_candidates);

  /// Best first, image pixels, right to about a tenth of lambda/d; at most max_candidates. Not
  /// every one is a spot. Valid until the next call. RT-safe.
  std::span<const Vec2> find(const ImageView& image) OVWS_NONBLOCKING;

 private:
  struct Tap {
    int dx = 0, dy = 0;
    float weight = 0.0F;
  };
  struct Peak {
    float score = 0.0F;
    int column = 0, row = 0;
  };
  using Grid = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  using Crowded = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr int kStrip = 32;

  void average(const ImageView& image);
  void add_row(const ImageView& image, Eigen::Index row, int top, int bottom);
  void correlate();
  template <int kCount>
  void correlate_strip(Eigen::Index row, Eigen::Index first, Eigen::Index count);
  void collect_peaks();
  void keep_separate();

  PixelLattice lattice_;  ///< the lit pixels: all below counts these
  int bin_;               ///< pixels a side that make one pixel of the grid
  int margin_;            ///< of the grid, around the image: edge pixels repeated
  double apart_;
  std::vector<Tap> taps_;
  std::vector<Tap> near_;  ///< grid places closer than apart_; weights play no part
  Grid grid_;
  Grid score_;
  Crowded crowded_;  ///< too near a candidate to be another one
  std::vector<Peak> peaks_;
  std::vector<Vec2> candidates_;
  std::size_t max_candidates_;
};

}  // namespace ovws
