/// Frame by frame what was measured in a number of frames.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

struct SeriesFrame {
  std::uint64_t frame_id = 0;
  std::int64_t t_arrival_ns = 0;    ///< UNIX epoch UTC
  float saturated_fraction = 0.0F;  ///< of the spots
  std::vector<SpotFix> spots;       ///< one a subaperture
};

/// Makes room for its frames when it is made: `add` does not allocate without `windows_px`.
class FrameSeries {
 public:
  /// `windows_px`: empty, or the centre of a window for each spot; the spot's position is then the
  /// centroid of its window (see cell_centroid) instead of what the tracker found.
  FrameSeries(int frames, int subapertures, std::vector<Vec2> windows_px = {});

  bool needs_pixels() const { return !windows_px_.empty(); }
  /// False: it is full, or the frame has another number of spots, or of windows. Reads the pixels
  /// if it needs them.
  bool add(const FrameRecord& record);
  /// Those that were added. Call once.
  std::vector<SeriesFrame> take();

 private:
  std::vector<SeriesFrame> frames_;
  std::size_t count_ = 0, subapertures_;
  std::vector<Vec2> windows_px_;
};

}  // namespace ovws
