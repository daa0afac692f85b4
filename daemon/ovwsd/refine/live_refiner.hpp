/// Refines frames beside the fast estimate, at a rate of its own, and publishes what it found.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/refine/refine_model.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/messages.hpp"
#include "proto/refine_setup.hpp"
#include "proto/requests.hpp"
#include "proto/tables/status.hpp"

namespace ovws {

/// The refine thread's agent. A turn with a frame lasts as long as its fit: seconds. Whatever
/// changes meanwhile, a frame is published with the hologram, the sensor and the reference that it
/// was measured with.
class LiveRefiner : public Agent {
 public:
  LiveRefiner(const RefineSetup& settings, const OpticsConfig& optics, const SlmGeometry& slm,
              FrameBroker& frames, const SensorKeeper& keeper, StreamQueue& queue);

  bool do_work() override;

  // Thread-safe.
  /// `format`: the camera's, whose DN the change is in. Errors as of check_refine; then nothing has
  /// changed. What is being refined by other ones is not published.
  Result<RefineSetup> change(const RefineSet& change, PixelFormat format);
  RefineSetup settings() const { return settings_.get(); }
  StatusMessage::RefinePart report() const { return report_.get(); }
  /// Begins no more fits; the one that runs ends within an iteration or two.
  void end_soon() { ending_.store(true); }

 private:
  void tell(std::string state, std::optional<std::string> reason);
  void wait_for_frame();
  void refine(const FrameCopy& frame, const SensorSnapshot& sensor, const RefineSetup& settings);
  void publish(const FrameCopy& frame, const SensorSnapshot& sensor, RefinedFrame refined);

  const double wavelength_nm_;
  const SensorKeeper& keeper_;
  StreamQueue& queue_;
  std::atomic<bool> ending_{false};
  RefineModel model_;  ///< after ending_, which stops it
  FrameInbox inbox_;
  Guarded<RefineSetup> settings_;
  Guarded<StatusMessage::RefinePart> report_;
  std::int64_t last_begun_ns_ = 0;     ///< of a fit; 0: none yet
  std::int64_t waiting_since_ns_ = 0;  ///< for a frame; 0: not waiting
};

}  // namespace ovws
