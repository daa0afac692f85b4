/// Renders the templates of the tracker `fit` about the wavefront of the newest frames.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/agent.hpp"
#include "core/spots/point_model.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// Agent of the templates thread. When templates do not describe the frames, or the wavefront has
/// drifted from their operating point, it finds the wavefront of the next frame by rendering its
/// spots, which takes some 50 ms, or up to a second for a frame that is not valid. Templates
/// about it go to the SensorKeeper.
class TemplateRenderer : public Agent {
 public:
  TemplateRenderer(const SlmGeometry& slm, FrameBroker& frames, SensorKeeper& keeper,
                   Events& events);
  ~TemplateRenderer() override;

  bool do_work() override;

  /// Publish thread: call for every frame.
  void on_frame(const FrameRecord& record);

 private:
  struct Model;
  Result<void> make_model(std::span<const ImageView> images, const SensorSnapshot& sensor);
  Result<void> render(std::span<const FrameCopy> frames, const SensorSnapshot& sensor);
  std::vector<std::vector<double>> starts(const FrameCopy& frame) const;
  void report(const Result<void>& rendered);

  SlmGeometry slm_;
  SensorKeeper& keeper_;
  Events& events_;
  FrameInbox inbox_;
  std::unique_ptr<Model> model_;
  std::atomic<bool> wanted_{false};
  // Templates thread only.
  std::int64_t next_ns_ = 0;  ///< not before; after a failure
  std::int64_t pause_ns_ = 0;
  std::string failure_;  ///< announced
  /// Epoch and time of a reference whose image the model does not explain.
  std::optional<std::pair<std::uint64_t, std::int64_t>> unexplained_;
};

}  // namespace ovws
