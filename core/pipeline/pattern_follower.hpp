/// Which pattern of a DMD's sequence each frame of the camera shows.
///
/// A DMD in its pattern mode plays a cycle of binary images, each for an equal time, and triggers
/// the camera with each. The first of them is dark: the mark. Frames can be lost, so a frame's
/// pattern follows from its time since the last mark, never from its number.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {

/// Sum of the pixels of every fourth row. RT-safe.
double light_of(const ImageView& image) OVWS_NONBLOCKING;

/// Follows the cycle from frame to frame. A frame's slot is certain if
/// - a whole cycle without a lost frame was seen before, of which the first and the next first
///   frame alone were dark: less light than midway between the darkest and the brightest frame,
/// - no frame since was dark where it should be bright, or bright where it should be dark,
/// - the mark of its own cycle was seen, and
/// - its time is a whole number of slots after that mark, within a quarter of a slot.
/// One thread at a time. RT-safe.
class PatternFollower {
 public:
  static constexpr int kUncertain = -1;

  /// The slot of the next frame, in the order of their times; kUncertain if it is not certain.
  /// `t_ns`: when the frame was exposed, by the camera's clock. `light`: see light_of.
  int follow(const PatternCycle& cycle, std::int64_t t_ns, double light) OVWS_NONBLOCKING;

  /// Forgets the cycle: another sequence or another stream has begun, or may have.
  void reset() OVWS_NONBLOCKING { *this = PatternFollower{}; }

 private:
  struct Seen {
    std::int64_t t_ns = 0;
    double light = 0.0;
  };
  void search(const PatternCycle& cycle) OVWS_NONBLOCKING;
  int slot_of(const PatternCycle& cycle, const Seen& now) OVWS_NONBLOCKING;
  void lose() OVWS_NONBLOCKING;

  std::array<Seen, kMaxPatternSlots + 1> seen_{};  ///< the newest frames, in turn
  std::int64_t count_ = 0;                         ///< of frames in seen_ so far
  bool found_ = false;                             ///< the members below are known
  double limit_ = 0.0;                             ///< less light is dark
  double period_ns_ = 0.0;                         ///< of a slot, as measured
  std::int64_t t_mark_ns_ = 0;                     ///< of the last mark
};

}  // namespace ovws
