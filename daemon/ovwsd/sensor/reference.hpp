/// The reference: where each spot is without the aberration to be measured, averaged over frames.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/spot.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/sensor/reference_picture.hpp"

namespace ovws {

/// What a reference belongs to: with anything else its positions mean nothing.
struct ReferenceKey {
  SensorConfig sensor;
  TrackingSettings tracking;
  Roi roi;
  friend bool operator==(const ReferenceKey&, const ReferenceKey&) = default;
};

/// `templates` matters to a tracker that has one only, `mode_operator` to no position.
ReferenceKey reference_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                           const Roi& roi);

enum class ReferenceSource {
  measured,  ///< averaged from frames
  model,     ///< where the configuration says that spots are: misalignment is in the coefficients
};
constexpr const char* reference_source_name(ReferenceSource source) {
  return source == ReferenceSource::model ? "model" : "measured";
}

struct Reference {
  ReferenceKey key;
  ReferenceSource source = ReferenceSource::measured;
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  std::optional<Registration> registration;  ///< in force while it was taken
  std::vector<Mode> aberration;              ///< shown while it was taken, RMS-normalised waves
  std::vector<Mode> introduced;  ///< the part of it that was introduced, not a correction
  std::vector<Vec2> positions_px;
  std::vector<Vec2> standard_error_px;
  std::shared_ptr<const ReferencePicture> picture;  ///< none: too few frames, or long ago
  std::shared_ptr<const nlohmann::json> origin;     ///< see ReferenceBench; none: not of a daemon
  std::string sha256;                               ///< of the file that keeps it; empty: none does
};

/// Root sum square, RMS-normalised waves.
double rms_waves(const std::vector<Mode>& modes);

/// Averages spots over settled frames. `begin` and `cancel` from any thread, `add` from the publish
/// thread.
class ReferenceCollector {
 public:
  struct Average {
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
  using Done = std::function<void(Average)>;

  /// Averages `frames` settled frames measured with a plan of this epoch while this hologram was
  /// shown, then calls `done` in the publish thread.
  void begin(int frames, std::uint64_t sensor_epoch, std::uint64_t hologram_id, int subapertures,
             Done done);
  void cancel();
  void add(const FrameRecord& record);
  /// 0 .. 1; 0 when nothing is being taken.
  double progress() const;
  /// Seconds since the last frame that was used, or since `begin`; 0 when nothing is being taken.
  double idle_s() const;

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
  Average average() const;
  void measure_motion(Average& average) const;

  mutable std::mutex mutex_;
  int wanted_ = 0;
  int used_ = 0;
  std::uint64_t sensor_epoch_ = 0;
  std::uint64_t hologram_id_ = 0;
  std::int64_t t_last_used_ns_ = 0;
  std::vector<Sums> sums_;
  Done done_;
};

/// Whether frames make a reference. Errc::refused: more than a tenth of all spots in all frames are
/// saturated (field "camera.exposure_us"), or the spots moved by more than `most_motion_px`:
/// drift_px, or scatter_px, without their noise.
Result<void> check_average(const ReferenceCollector::Average& average, double most_motion_px);
/// Numbers of the spots that were saturated in at least one frame.
std::vector<int> saturated_spots(const ReferenceCollector::Average& average);
/// "1, 4, 7 and 12 more".
std::string listed_spots(const std::vector<int>& numbers);

}  // namespace ovws
