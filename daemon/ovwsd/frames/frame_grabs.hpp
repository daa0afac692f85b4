/// Grabs of frames for clients (camera.grab): copies frames out of the camera's buffers until a
/// request is complete.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.hpp"
#include "core/pipeline/frame_record.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "proto/tables/picture.hpp"

namespace ovws {

/// Open grabs. Their pixels take limits::kGrabBytes each and twice as much in total at most, from
/// the first frame until the reply was sent.
class FrameGrabs {
 public:
  using Pixels = std::shared_ptr<const std::string>;
  using Done = std::function<void(Result<GrabReport>, Pixels)>;

  /// `frames` must outlive this object. `newest` returns the number of the hologram that the SLM
  /// shows, 0 without a display, in any thread.
  FrameGrabs(FrameTaps& frames, std::function<std::uint64_t()> newest);
  FrameGrabs(const FrameGrabs&) = delete;
  FrameGrabs& operator=(const FrameGrabs&) = delete;
  ~FrameGrabs();

  /// Opens a grab. Thread-safe. `done` is called in the images thread, or at once on an error.
  /// Errors: Errc::invalid, the region is not in the image, or too many bytes; Errc::refused, the
  /// hologram was replaced or was never shown, or too many grabs are open; Errc::unavailable, the
  /// frames did not come in time, or the SLM shows no hologram.
  void grab(const CameraGrab& wish, Done done);
  /// Lets `end_due` end the open grabs: the daemon stops. Thread-safe.
  void end_soon() { ending_ = true; }
  /// Ends the grabs that are complete, have failed or are too late. Images thread.
  void end_due();

 private:
  class Grab;
  FrameTaps& frames_;
  const std::function<std::uint64_t()> newest_;
  std::shared_ptr<std::atomic<std::size_t>> bytes_in_use_ =
      std::make_shared<std::atomic<std::size_t>>(0);
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::vector<std::unique_ptr<Grab>> open_;
};

}  // namespace ovws
