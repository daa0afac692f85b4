/// Frame by frame what was measured of a number of settled frames.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/frames/frame_taker.hpp"

namespace ovws {

struct SeriesFrame {
  std::uint64_t frame_id = 0;
  std::int64_t t_arrival_ns = 0;    ///< UNIX epoch UTC
  float saturated_fraction = 0.0F;  ///< of the spots
  std::vector<SpotFix> spots;       ///< one a subaperture
};

/// `begin`, `taken` and `end` from any thread, `add` from the publish thread, which looks at one
/// flag while nothing is wanted and never allocates.
class FrameSeriesTaker : public FrameTaker {
 public:
  /// Which frames: settled, of this hologram, epoch, tracker and gain.
  struct Wanted {
    int frames = 0;
    std::uint64_t sensor_epoch = 0;
    std::uint64_t hologram_id = 0;
    TrackerKind tracker = TrackerKind::lg;
    double gain_db = 0.0;  ///< as read back; see CameraSettings, as gain_raw
    int spots = 0;         ///< the most a frame has
    /// Not empty: where the tracker found a spot is replaced by the centroid of the cell around its
    /// centre here; see cell_centroid.
    std::vector<Vec2> cells{};
  };

  void begin(const Wanted& wanted);
  void add(const FrameRecord& record);
  bool wants() override;
  void take(const FrameRecord& record) override;
  int taken() const;
  /// What was taken so far, and no more frames.
  std::vector<SeriesFrame> end();

 private:
  enum class From { nothing, spots, pixels };

  // Call with mutex_ locked.
  bool is_wanted(const FrameRecord& record) const;
  void keep(const FrameRecord& record);

  std::atomic<From> from_{From::nothing};
  mutable std::mutex mutex_;  ///< held for copies only: the publish thread may wait for it
  Wanted wanted_;
  std::uint64_t series_ = 0;         ///< counts `begin`
  std::vector<SeriesFrame> frames_;  ///< all that are wanted, with room for their spots
  int taken_ = 0;
};

}  // namespace ovws
