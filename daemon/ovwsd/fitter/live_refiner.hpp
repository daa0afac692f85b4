/// Live refinement: fits frames to the rendered model beside the frame path, at its own rate, and
/// publishes the results as `refined` messages.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/control/refine_settings.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/fitter/refine_model.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/messages.hpp"
#include "proto/requests.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// Agent of the refine thread. A turn with a frame lasts as long as the fit. Each result belongs to
/// the hologram, sensor and reference with which its frame was measured, even if they change during
/// the fit.
class LiveRefiner : public Agent {
 public:
  LiveRefiner(const RefineSetup& settings, const OpticsConfig& optics, const SlmGeometry& slm,
              FrameTaps& frames, const SensorKeeper& keeper, StreamQueue& queue);

  bool do_work() override;

  // Thread-safe methods.
  /// Changes the settings. Grey levels in `change` are in DN of `format`, the camera's pixel
  /// format. On an error (see check_refine) nothing changes. A fit that ran with the previous
  /// settings is not published.
  Result<RefineSetup> change(const RefineSet& change, PixelFormat format);
  RefineSetup settings() const { return settings_.get(); }
  StatusMessage::RefinePart report() const;
  /// Stops starting new fits, before the thread ends.
  void end_soon() { ending_.store(true); }

 private:
  void set_state(std::string state, std::optional<std::string> reason);
  void wait_for_frame();
  void refine(const FrameCopy& frame, const SensorSnapshot& sensor, const RefineSetup& settings);
  void publish(const FrameCopy& frame, const SensorSnapshot& sensor, RefinedFrame refined);

  const double wavelength_nm_;
  const SensorKeeper& keeper_;
  StreamQueue& queue_;
  std::atomic<bool> ending_{false};
  RefineModel model_;
  FrameInbox inbox_;
  Guarded<RefineSetup> settings_;
  Guarded<StatusMessage::RefinePart> report_;
  std::int64_t last_due_ns_ = 0;       ///< when the last fit was due; 0: none yet
  std::int64_t waiting_since_ns_ = 0;  ///< start of the wait for a frame; 0: not waiting
};

}  // namespace ovws
