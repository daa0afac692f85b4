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
  /// Largest numbers of candidates: near the expected spots, and in the rest of the image.
  struct Most {
    int near = 0, elsewhere = 0;
  };
  /// Parts of the image, camera pixels.
  struct Parts {
    std::optional<Disc> near{};    ///< where spots are expected; none: nowhere
    std::optional<Disc> within{};  ///< where to look; none: in the whole image
  };

  CandidateFinder(const SpotModel& spots, int image_width, int image_height, Most most);

  /// Finds the best candidates near the expected spots, and the best ones elsewhere, in camera
  /// pixels, accurate to about 0.1 lambda/d. Bright light elsewhere takes no place of a candidate
  /// near the expected spots. Candidates are sorted, the best first; some are not spots. The span
  /// is valid until the next call. RT-safe.
  std::span<const Vec2> find(const ImageView& image, const Parts& parts) OVWS_NONBLOCKING;

 private:
  struct Tap {
    int dx = 0, dy = 0;
    float weight = 0.0F;
  };
  struct Peak {
    float score = 0.0F;
    int column = 0, row = 0;
    bool near = false;  ///< near the expected spots
  };
  static bool better(const Peak& a, const Peak& b) { return a.score > b.score; }
  static void keep_best(const Peak& peak, std::vector<Peak>& heap);
  using Grid = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr int kStrip = 32;

  void average(const ImageView& image);
  void add_row(const ImageView& image, Eigen::Index row, int top, int bottom);
  void correlate();
  template <int kCount>
  void correlate_strip(Eigen::Index row, Eigen::Index first, Eigen::Index count);
  Vec2 place_of(int column, int row) const;
  void collect_peaks(const Parts& parts);
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
  std::vector<Peak> near_peaks_, other_peaks_;
  std::vector<Peak> peaks_;  ///< both, the best first
  std::vector<Vec2> candidates_;
  Most most_;
};

}  // namespace ovws
