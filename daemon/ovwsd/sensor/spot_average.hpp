/// Spot positions averaged over frames: mean, standard error, and how much of the scatter is
/// motion.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

struct SpotAverage {
  int frames = 0;              ///< that were used
  std::vector<int> found;      ///< in how many of them, per spot
  std::vector<int> saturated;  ///< in how many of them it held a pixel at full scale, per spot
  std::vector<Vec2> mean_px, standard_error_px;
  // RMS over spots, x and y, camera pixels; 0 for a single frame:
  double scatter_px = 0.0;      ///< of single frames about their mean
  double noise_px = 0.0;        ///< the part of it that changes from each frame to the next
  double drift_px = 0.0;        ///< from the mean of the first half to that of the second
  double drift_noise_px = 0.0;  ///< what noise_px alone makes of drift_px
};

/// Accumulates by Welford's algorithm; `add` does not allocate.
class SpotAverager {
 public:
  /// `frames`: how many will be added, for the first and the second half.
  SpotAverager(int frames, int subapertures);
  /// False: the frame has another number of spots, and is not used.
  bool add(const FrameRecord& record);
  /// The same; a spot whose brightest pixel reaches `full_dn` is saturated.
  bool add(std::span<const SpotFix> spots, double full_dn);
  SpotAverage average() const;

 private:
  struct Sums {
    int found = 0, saturated = 0;
    Vec2 mean, m2;        ///< Welford's running mean and sum of squared deviations
    Vec2 last;            ///< where it was found last
    Vec2 steps;           ///< sum of squared differences of successive positions
    int found_first = 0;  ///< in the first half of the frames
    Vec2 mean_first;      ///< over those
  };
  static void add_position(Sums& sums, Vec2 at, bool in_first_half);
  void measure_motion(SpotAverage& average) const;

  const int frames_;
  int used_ = 0;
  std::vector<Sums> sums_;
};

/// Mean positions; NaN for spots that were found in fewer than half of the frames, or once only.
std::vector<Vec2> found_positions(const SpotAverage& average);
/// Checks that the averaged frames can serve as a reference. Errc::refused: more than a tenth of
/// all spots in all frames are saturated (field "camera.exposure_us"), or the spots moved by more
/// than `max_motion_px`: drift_px or scatter_px, after allowing for noise.
Result<void> check_average(const SpotAverage& average, double max_motion_px);
/// Indices of the spots that were saturated in at least one frame.
std::vector<int> saturated_spots(const SpotAverage& average);
/// "1, 4, 7 and 12 more".
std::string listed_spots(const std::vector<int>& numbers);

}  // namespace ovws
