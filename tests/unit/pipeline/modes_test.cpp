/// Inline, one worker and three workers in threads of their own give the same numbers, bit for bit.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <thread>

#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

/// What is measured of a frame, as bytes.
struct Measured {
  std::uint64_t frame_id = 0, gap = 0;
  int tracked = 0;
  bool valid = false;
  std::vector<SpotFix> spots;
  std::vector<float> coefficients;
  double fit_residual_px = 0.0, rms_waves = 0.0;
};

Measured copy_of(const FrameRecord& record) {
  return {record.frame.frame_id,
          record.gap,
          record.tracked,
          record.valid,
          {record.spots.begin(), record.spots.begin() + record.spot_count},
          {record.coefficients.begin(), record.coefficients.begin() + record.mode_count},
          record.reconstruction.fit_residual_px,
          record.reconstruction.rms_waves};
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// A walk, a dark spot, a jump that needs a search, blackness, and the return.
std::vector<std::shared_ptr<const Image<std::uint8_t>>> script(const SpotBench& bench) {
  std::vector<std::shared_ptr<const Image<std::uint8_t>>> images;
  for (int i = 0; i < 40; ++i) {
    const Vec2 walk{3.3 * i, 1.7 * i};
    if (i < 10) {
      images.push_back(SpotBench::draw(bench.moved({{3, 0.02 * i}}, walk)));
    } else if (i < 20) {
      images.push_back(SpotBench::draw(bench.moved({{5, -0.03 * i}}, walk), {i - 10, 18}));
    } else if (i < 28) {
      images.push_back(SpotBench::draw(bench.moved({{8, 0.1}}, {-20.0, -30.0})));
    } else if (i < 32) {
      images.push_back(SpotBench::black());
    } else {
      images.push_back(SpotBench::draw(bench.moved({{12, 0.1}})));
    }
  }
  return images;
}

/// Runs every agent of a pipeline in its own thread until it is destroyed.
class Threads {
 public:
  Threads(Pipeline& pipeline, int workers) {
    run(pipeline.acquisition());
    for (int k = 0; k < workers; ++k) run(pipeline.tracker(k));
    if (workers > 0) run(pipeline.reconstruction());
  }
  ~Threads() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  void run(Agent& agent) {
    threads_.emplace_back([this, &agent] {
      while (!stop_) agent.do_work();
      agent.on_close();
    });
  }
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

/// Runs the script with real threads while images are requested, so that buffers change hands.
std::vector<Measured> measure_with(int workers) {
  PipelineRig rig(workers, 64, 5);
  rig.use(rig.bench.plan(1));
  std::vector<Measured> measured;
  const auto images = script(rig.bench);
  {
    Threads threads(rig.pipeline, workers);
    EXPECT_TRUE(rig.pipeline.attach(rig.camera));
    for (std::size_t i = 0; i < images.size(); ++i) rig.send(i + 1, images[i]);
    for (int patience = 0; measured.size() < images.size() && patience < 2000; ++patience) {
      rig.pipeline.request_image();
      FrameRecord* const record = rig.pipeline.next(10'000);
      if (record != nullptr) {
        measured.push_back(copy_of(*record));
        rig.pipeline.release(record);
      }
      if (FrameRecord* const image = rig.pipeline.next_image(0)) rig.pipeline.release_image(image);
    }
    std::atomic<bool> detached{false};
    std::thread image_thread([&] {  // what was asked for last may still be on its way
      while (!detached) {
        FrameRecord* const image = rig.pipeline.next_image(10'000);
        if (image != nullptr) rig.pipeline.release_image(image);
      }
    });
    EXPECT_TRUE(rig.pipeline.detach());
    detached = true;
    image_thread.join();
  }
  EXPECT_EQ(rig.camera.lent(), 0);
  EXPECT_EQ(rig.count(Counter::frames_dropped), 0U);
  return measured;
}

void expect_equal(const std::vector<Measured>& a, const std::vector<Measured>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].frame_id, b[i].frame_id);
    EXPECT_EQ(a[i].gap, b[i].gap);
    EXPECT_EQ(a[i].tracked, b[i].tracked) << "frame " << a[i].frame_id;
    EXPECT_EQ(a[i].valid, b[i].valid) << "frame " << a[i].frame_id;
    EXPECT_TRUE(same_bytes(a[i].spots, b[i].spots)) << "frame " << a[i].frame_id;
    EXPECT_TRUE(same_bytes(a[i].coefficients, b[i].coefficients)) << "frame " << a[i].frame_id;
    EXPECT_EQ(std::memcmp(&a[i].fit_residual_px, &b[i].fit_residual_px, sizeof(double)), 0);
    EXPECT_EQ(std::memcmp(&a[i].rms_waves, &b[i].rms_waves, sizeof(double)), 0);
  }
}

TEST(Modes, InlineAndThreadedGiveIdenticalNumbers) {
  const std::vector<Measured> inlined = measure_with(0);
  ASSERT_EQ(inlined.size(), 40U);
  EXPECT_EQ(inlined[5].tracked, 19);
  EXPECT_EQ(inlined[15].tracked, 17);
  EXPECT_EQ(inlined[22].tracked, 19);
  EXPECT_EQ(inlined[30].tracked, 0);
  EXPECT_EQ(inlined[39].tracked, 19);
  expect_equal(inlined, measure_with(1));
  expect_equal(inlined, measure_with(3));
}

TEST(Modes, MoreWorkersThanSpotsDoNoHarm) {
  expect_equal(measure_with(0), measure_with(24));
}

}  // namespace
}  // namespace ovws::test
