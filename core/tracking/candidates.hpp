/// Candidate detection: where in a whole image spots may be.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Matched filter on a binned image of about three bins per lambda/d. Its kernel is the ideal spot
/// minus the mean, so that a flat background scores 0. Non-maximum suppression keeps the best
/// maxima that are at least about a spot's radius apart. The constructor allocates all memory, for
/// one image size.
class CandidateFinder {
 public:
  CandidateFinder(const SpotModel& spots, int image_width, int image_height, int max_candidates);

  /// Finds at most max_candidates candidate positions, best first, in camera pixels, accurate to
  /// about 0.1 lambda/d. Some candidates are not spots. The span is valid until the next call.
  /// `within`: the part of the image, camera pixels, to look in; none: all of it. RT-safe.
  std::span<const Vec2> find(const ImageView& image,
                             const std::optional<Disc>& within = std::nullopt) OVWS_NONBLOCKING;

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

  using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr int kStrip = 32;

  void average(const ImageView& image);
  void add_row(const ImageView& image, Eigen::Index row, int top, int bottom);
  void correlate();
  template <int kCount>
  void correlate_strip(Eigen::Index row, Eigen::Index first, Eigen::Index count);
  Vec2 place_of(int column, int row) const;
  void collect_peaks(const std::optional<Disc>& within);
  void suppress_neighbours();

  ColourPlane plane_;  ///< the colour plane that receives the laser's light
  int bin_;            ///< pixels of the colour plane per side of a bin
  int margin_;         ///< width of the border around the image, which repeats its edge; bins
  double min_distance_;
  std::vector<Tap> taps_;
  std::vector<Tap>
      near_offsets_;  ///< grid offsets closer than min_distance_; their weights are not used
  Grid grid_;
  Grid score_;
  Mask suppressed_;  ///< bins too near an accepted candidate
  std::vector<Peak> peaks_;
  std::vector<Vec2> candidates_;
  std::size_t max_candidates_;
};

}  // namespace ovws
