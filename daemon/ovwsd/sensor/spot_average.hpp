/// Spot positions averaged over frames: mean, standard error, and how much of the scatter is due to
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
  int frames = 0;              ///< number of averaged frames
  std::vector<int> found;      ///< per spot: number of frames in which it was found
  std::vector<int> saturated;  ///< per spot: number of frames with a pixel at full scale
  std::vector<Vec2> mean_px, standard_error_px;
  // RMS over all spots and over x and y, in camera pixels; 0 for a single frame:
  double scatter_px = 0.0;      ///< positions in single frames about their mean
  double noise_px = 0.0;        ///< part of the scatter that changes from frame to frame
  double drift_px = 0.0;        ///< mean position: change from first to second half of frames
  double drift_noise_px = 0.0;  ///< drift_px to be expected from noise_px alone
};

/// Largest motion of the spots during a measurement that assumes them to be still, lambda/d.
constexpr double kMaxMotion = 0.05;

/// Averages spot positions by Welford's algorithm; `add` does not allocate.
class SpotAverager {
 public:
  /// `frames`: number of frames to be added; decides which belong to the first half.
  SpotAverager(int frames, int subapertures);
  /// Adds a frame. Returns false if the frame has another number of spots; it is then not used.
  bool add(const FrameRecord& record);
  /// Adds the spots of a frame. A spot counts as saturated if its peak reaches `full_dn`.
  bool add(std::span<const SpotFix> spots, double full_dn);
  SpotAverage average() const;

 private:
  struct Sums {
    int found = 0, saturated = 0;
    Vec2 mean, m2;        ///< Welford's running mean and sum of squared deviations
    Vec2 last;            ///< position in the last frame with this spot
    Vec2 steps;           ///< sum of squared differences of successive positions
    int found_first = 0;  ///< number of frames of the first half with this spot
    Vec2 mean_first;      ///< mean position in the first half
  };
  static void add_position(Sums& sums, Vec2 at, bool in_first_half);
  void measure_motion(SpotAverage& average) const;

  const int frames_;
  int used_ = 0;
  std::vector<Sums> sums_;
};

/// Mean spot positions; NaN for a spot that was found in fewer than half of the frames, or in only
/// one of several.
std::vector<Vec2> found_positions(const SpotAverage& average);
/// Checks that the averaged frames can serve as a reference. Errc::refused: more than a tenth of
/// all spots in all frames are saturated (field "camera.exposure_us"), or the spots moved, so that
/// drift_px or scatter_px exceeds `max_motion_px` by more than noise explains.
Result<void> check_average(const SpotAverage& average, double max_motion_px);
/// Indices of the spots that were saturated in at least one frame.
std::vector<int> saturated_spots(const SpotAverage& average);
/// Spot numbers for a message, such as "1, 4, 7 and 12 more".
std::string listed_spots(const std::vector<int>& numbers);

}  // namespace ovws
