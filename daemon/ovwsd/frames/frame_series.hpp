/// Frame by frame what was measured in a number of frames.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

struct SeriesFrame {
  std::uint64_t frame_id = 0;
  std::int64_t t_arrival_ns = 0;    ///< UNIX epoch UTC
  float saturated_fraction = 0.0F;  ///< of the spots
  std::vector<SpotFix> spots;       ///< one a subaperture
};

/// Where the positions of spots come from instead of the frames' own.
struct FromPixels {
  /// The centre of a window for each spot, whose centroid counts (see cell_centroid); empty: none.
  std::vector<Vec2> windows_px;
  /// Finds each spot again, from where it was found; null: none.
  std::shared_ptr<const SpotTracker> tracker;
};

/// Makes room for its frames when it is made: `add` does not allocate unless it needs pixels.
class FrameSeries {
 public:
  FrameSeries(int frames, int subapertures, FromPixels from = {});

  bool needs_pixels() const { return !from_.windows_px.empty() || from_.tracker; }
  /// False: it is full, or the frame has another number of spots, or of windows. Reads the pixels
  /// if it needs them.
  bool add(const FrameRecord& record);
  /// Those that were added. Call once.
  std::vector<SeriesFrame> take();

 private:
  std::vector<SeriesFrame> frames_;
  std::size_t count_ = 0, subapertures_;
  FromPixels from_;
  TrackScratch scratch_;
};

}  // namespace ovws
