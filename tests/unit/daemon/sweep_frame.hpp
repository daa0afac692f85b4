/// Frames of a sweep.
#pragma once

#include <vector>

#include "daemon/ovwsd/procedures/sweep_frames.hpp"

namespace ovws::test {

/// A frame whose spots were all found, at these places.
inline SeriesFrame frame_at(const std::vector<Vec2>& places) {
  SeriesFrame frame;
  for (const Vec2 p : places) {
    SpotFix spot;
    spot.x = float(p.x);
    spot.y = float(p.y);
    spot.level = 10.0F;
    spot.noise = 2.0F;
    spot.peak = 20.0F;
    frame.spots.push_back(spot);
  }
  return frame;
}

}  // namespace ovws::test
