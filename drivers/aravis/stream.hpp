/// One running acquisition: page-aligned buffers of our own that Aravis receives into, lent out
/// frame by frame.
#pragma once

#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/aravis/frame_id.hpp"
#include "drivers/aravis/genicam_device.hpp"
#include "drivers/aravis/stray_frames.hpp"

namespace ovws {

/// What every frame of this acquisition must be.
struct FrameShape {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
};

/// Before a stream is made: packet size (GigE) and transfer mode (USB3).
Result<void> prepare_transport(GenicamDevice& device, const AravisConfig& config);

/// Made and destroyed by the camera thread; `grab` and `release` belong to the acquisition thread.
/// Making it does not start the camera. Its end takes up to 5 s if the camera does not answer.
class AravisStream {
 public:
  /// `ids` must outlive the stream; only grab uses it.
  static Result<std::unique_ptr<AravisStream>> open(GenicamDevice& device,
                                                    const AravisConfig& config,
                                                    const FrameShape& shape, FrameIdUnwrapper& ids);
  ~AravisStream();
  AravisStream(const AravisStream&) = delete;
  AravisStream& operator=(const AravisStream&) = delete;

  /// Arrival stamps are taken right after the frame was popped, so they hold the thread's own
  /// wake-up time. A frame that is damaged or not of the expected shape is `incomplete`.
  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout);
  /// Takes effect at the next grab, because Aravis's queue locks and allocates.
  void release(int slot) OVWS_NONBLOCKING;

 private:
  AravisStream(GRef<ArvStream> stream, const FrameShape& shape, FrameIdUnwrapper& ids,
               const StrayFrames& strays);
  bool allocate(std::size_t payload_bytes, int count);
  void requeue_released();
  GrabStatus stray();
  void count_strays();
  bool view_image(ArvBuffer* buffer, ImageView& image) const;

  /// Aravis's numbers of what it counts; by name it would search for them at each grab.
  struct PacketCounts {
    guint ignored = 0, starved = 0;
  };
  static std::optional<PacketCounts> packet_counts(ArvStream* stream);

  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  FrameShape shape_;
  FrameIdUnwrapper* ids_;
  StrayFrames strays_;
  StrayFrames::Counts untold_;
  std::optional<PacketCounts> packets_;  ///< none with a USB camera, whose frames are not packets
  std::unique_ptr<std::byte, Free> memory_;  // outlives the stream, whose thread writes into it
  GRef<ArvStream> stream_;
  std::vector<ArvBuffer*> lent_;      // by slot; null while Aravis has it
  std::vector<ArvBuffer*> released_;  // never grows beyond its first reservation
};

}  // namespace ovws
