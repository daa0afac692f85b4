/// Who wants pixels of frames for itself: the images thread hands them on.
#pragma once

#include "core/pipeline/frame_record.hpp"

namespace ovws {

class FrameTaker {
 public:
  virtual ~FrameTaker() = default;
  /// Images thread: whether frames are to be borrowed for it now.
  virtual bool wants() = 0;
  /// Images thread: a frame with its pixels, both lent until this returns, which is to be soon: a
  /// buffer of the camera waits.
  virtual void take(const FrameRecord& record) = 0;
};

}  // namespace ovws
