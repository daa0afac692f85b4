/// A pipeline with a scripted camera, turned by hand in one thread, so that nothing depends on
/// time.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "core/pipeline/pipeline.hpp"
#include "tests/support/time.hpp"
#include "tests/unit/pipeline/scripted_camera.hpp"
#include "tests/unit/pipeline/spot_bench.hpp"

namespace ovws::test {

/// Hologram 1 of sensor epoch 1 has stood since 1 ms; exposure 1 ms, 0 dB; no frame period, so no
/// deadline. Frame n arrives at 1000 ms + 10 ms n.
class PipelineRig {
 public:
  explicit PipelineRig(int workers = 0, int records = 64, int buffers = 8, int beams = 0,
                       int patterns = 0)
      : camera(buffers, SpotBench::kBytes),
        pipeline({workers, records, beams, patterns}, {counters, shown, settings}),
        workers_(workers) {
    show({1, 1, 0, kMs}, {});
    applied.exposure_us = 1000.0;
    settings.write(applied);
  }
  ~PipelineRig() {
    if (attached_) detach();
  }

  void show(ShownHologram::One current, ShownHologram::One previous) {
    ShownHologram now;
    now.current = current;
    now.previous = previous;
    now.healthy = true;
    shown.write(now);
  }

  void use(std::unique_ptr<MeasurementPlan> plan) {
    pipeline.use_plan(plan.get());
    plans.push_back(std::move(plan));
  }

  /// `attach` and `detach` wait for the agents, so they get a thread of their own meanwhile.
  Result<void> attach() {
    attached_ = true;
    return while_turning([&] { return pipeline.attach(camera); });
  }
  Result<void> detach() {
    attached_ = false;
    return while_turning([&] { return pipeline.detach(); });
  }

  static std::int64_t arrival_ns(std::uint64_t frame_id) {
    return 1000 * kMs + std::int64_t(frame_id) * 10 * kMs;
  }
  void send(std::uint64_t frame_id, std::shared_ptr<const Image<std::uint8_t>> image) {
    ScriptedFrame frame{frame_id, arrival_ns(frame_id), std::move(image)};
    if (stamped) frame.t_device_ns = frame.t_arrival_mono_ns;
    camera.send(std::move(frame));
  }

  /// Every agent in the order that a frame goes; none waits for a frame that cannot come.
  void turn() {
    if (pipeline.acquisition().do_work()) turn_workers();
  }
  void turn_workers() {
    for (int k = 0; k < workers_; ++k) pipeline.tracker(k).do_work();
    if (workers_ > 0) pipeline.reconstruction().do_work();
  }

  /// Sends one frame through, and returns its record, or nullptr if none came out.
  FrameRecord* measure(std::uint64_t frame_id, std::shared_ptr<const Image<std::uint8_t>> image) {
    send(frame_id, std::move(image));
    turn();
    return pipeline.next(0);
  }

  std::uint64_t count(Counter counter) const { return counters.get(counter); }

  Counters counters;
  LatestValue<ShownHologram> shown;
  LatestValue<AppliedSettings> settings;
  AppliedSettings applied;
  bool stamped = false;  ///< whether the camera sends timestamps
  ScriptedCamera camera;
  SpotBench bench;
  std::vector<std::unique_ptr<MeasurementPlan>> plans;
  Pipeline pipeline;

 private:
  template <class F>
  Result<void> while_turning(F&& ask) {
    Result<void> answer;
    std::atomic<bool> done{false};
    std::thread asking([&] {
      answer = ask();
      done = true;
    });
    while (!done) {
      turn();
      if (camera.lent() > 0) turn_workers();
    }
    asking.join();
    return answer;
  }

  const int workers_;
  bool attached_ = false;
};

/// A record that goes back when the scope ends.
class Taken {
 public:
  Taken(PipelineRig& rig, FrameRecord* record) : rig_(rig), record_(record) {}
  ~Taken() {
    if (record_ != nullptr) rig_.pipeline.release(record_);
  }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  explicit operator bool() const { return record_ != nullptr; }
  const FrameRecord* operator->() const { return record_; }
  const FrameRecord& operator*() const { return *record_; }

 private:
  PipelineRig& rig_;
  FrameRecord* record_;
};

}  // namespace ovws::test
