/// Stream of one acquisition: owns page-aligned buffers into which Aravis receives, and lends them
/// out frame by frame.
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

/// Expected size and format of every frame of an acquisition.
struct FrameShape {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::mono8;
};

/// Sets packet size (GigE) and transfer mode (USB3). Call this before a stream is created.
Result<void> prepare_transport(GenicamDevice& device, const AravisConfig& config);

/// Acquisition stream, created and destroyed in the camera thread. Only the acquisition thread
/// calls `grab` and `release`. Creation does not start the camera. Destruction takes up to 5 s if
/// the camera does not answer.
class AravisStream {
 public:
  /// Creates the stream and its buffers. `ids` must outlive the stream; only `grab` uses it.
  static Result<std::unique_ptr<AravisStream>> open(GenicamDevice& device,
                                                    const AravisConfig& config,
                                                    const FrameShape& shape, FrameIdUnwrapper& ids);
  ~AravisStream();
  AravisStream(const AravisStream&) = delete;
  AravisStream& operator=(const AravisStream&) = delete;

  /// Waits for the next frame. The arrival time is taken right after the frame leaves Aravis's
  /// queue, so it includes the thread's wake-up latency. A damaged frame, or a frame of unexpected
  /// size, is reported as `incomplete`, unless it is the stream's first.
  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout);
  /// Takes a lent buffer back. Only the next `grab` requeues the buffer, because Aravis's queue
  /// locks and allocates.
  void release(int slot) OVWS_NONBLOCKING;

 private:
  AravisStream(GRef<ArvStream> stream, const FrameShape& shape, FrameIdUnwrapper& ids,
               const StrayFrames& strays);
  bool allocate(std::size_t payload_bytes, int count);
  void requeue_released();
  GrabStatus stray();
  void count_strays();
  bool view_image(ArvBuffer* buffer, ImageView& image) const;

  /// Indices of Aravis's packet counters in its stream statistics. Looked up once, because a lookup
  /// by name searches the list.
  struct PacketCounts {
    guint ignored = 0, without_buffer = 0;
  };
  static std::optional<PacketCounts> packet_counts(ArvStream* stream);

  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  FrameShape shape_;
  FrameIdUnwrapper* ids_;
  bool awaits_first_ = true;
  StrayFrames strays_;
  StrayFrames::Counts unreported_;
  std::optional<PacketCounts> packets_;      ///< none for USB cameras, which have no packets
  std::unique_ptr<std::byte, Free> memory_;  // declared before stream_, which writes into it
  GRef<ArvStream> stream_;
  std::vector<ArvBuffer*> lent_;      // lent buffers by slot; null: not lent
  std::vector<ArvBuffer*> released_;  // to be requeued; reserved once, so it never allocates
};

}  // namespace ovws
