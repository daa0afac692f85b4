/// Wavefront search for frames that the active templates do not describe, with new templates as the
/// result.
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
#include "core/port/clock.hpp"
#include "core/rt/agent.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/tracking/binned_image.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/fitter/search_policy.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/sensor/validity_watch.hpp"

namespace ovws {

/// Agent of the search thread. It works when templates do not describe the frames, or when the
/// wavefront has drifted from the templates' operating point. It then finds the wavefront of the
/// next frame by rendering spots: some 50 ms, or up to a second for a frame that is not valid.
/// Templates about the found wavefront go to the SensorKeeper. In turbulent air they allow for
/// modes that are not measured. Near a calibration's wavefront, the calibration's templates are
/// used. After a failure, SearchPolicy decides when to try again. Templates are given up, so that
/// modes come from spot positions, at once if no model can be made, or when GivingUp says so.
///
/// With another tracker than `fit`, the agent only watches whether frames are valid, until a closed
/// loop has lost its spots. Templates then measure the frames until the loop has made the wavefront
/// flat enough for the tracker.
class WavefrontSearch : public Agent {
 public:
  /// All references must outlive this object.
  WavefrontSearch(const Config& config, FrameTaps& frames, const ImageBrightness& brightness,
                  SensorKeeper& keeper, Events& events);
  ~WavefrontSearch() override;

  bool do_work() override;

  /// Any thread: why no frame of a light source is valid, as ValidityWatch::why_invalid; none
  /// without a reference. Of the main source, the snapshot's obstacle comes first.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid(std::size_t source = 0) const;
  /// Any thread: CLOCK_MONOTONIC time of the last successful search; 0: none.
  std::int64_t found_ns() const { return found_ns_.load(std::memory_order_relaxed); }

 private:
  struct Model;
  void make_model(std::span<const ImageView> images, const SensorSnapshot& sensor);
  Result<void> render(std::span<const FrameCopy> frames, const SensorSnapshot& sensor);
  Result<std::shared_ptr<const FrameFit>> found(std::span<const ImageView> images,
                                                const FrameCopy& frame,
                                                const SensorSnapshot& sensor);
  bool looks_for_calibration() const;
  void on_frame(const FrameRecord& record);
  bool may_search(const FrameRecord& record);
  bool rest();
  void use_templates(std::shared_ptr<const FrameFit> fit, bool given_up = false);
  std::vector<std::vector<double>> starts(const FrameCopy& frame) const;
  bool take_frame(const SensorSnapshot& sensor);
  bool begin_if_due(const FrameCopy& frame, const SensorSnapshot& sensor);
  void report(const Result<void>& rendered, std::int64_t began_ns);
  void succeed();

  SlmGeometry slm_;
  SensorKeeper& keeper_;
  Events& events_;
  FrameInbox inbox_;
  std::unique_ptr<Model> model_;  ///< model used for the frame searched last
  std::atomic<bool> wanted_{false};
  std::atomic<bool> described_{false};  ///< the plan's templates describe the newest frame
  std::atomic<std::int64_t> found_ns_{0};
  std::atomic<int> undescribed_{0};   ///< frames without templates since the last failed search
  std::atomic<int> explained_{0};     ///< those of them that spot positions explain
  std::atomic<bool> is_flat_{false};  ///< the tracker can measure the newest frame again
  ValidityWatch validity_;
  std::int64_t t_valid_ns_ = 0;  ///< CLOCK_MONOTONIC of the last valid frame; publish thread only
  // Search thread only.
  std::int64_t next_ns_ = 0;       ///< do not search before this time
  std::vector<FrameCopy> frames_;  ///< successive frames of one sensor epoch and image size
  SearchPolicy policy_;
  GivingUp giving_up_;
  std::optional<BinnedImage> tried_;  ///< the image searched last
  std::uint64_t tried_plan_id_ = 0;
  std::string failure_;             ///< reason in the last failure event; empty: none
  bool measured_ = false;           ///< the last templates were the calibration's
  std::int64_t look_again_ns_ = 0;  ///< do not try the calibration's templates before
  FrameTap tap_;                    ///< calls on_frame, so declared last
};

}  // namespace ovws
