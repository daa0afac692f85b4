/// The recorder's documents while the disk stands still: its thread is the test's, which makes no
/// turn meanwhile.
#include "daemon/ovwsd/record/recorder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/loop/loop_log.hpp"
#include "daemon/ovwsd/record/loop_player.hpp"
#include "drivers/replay/recording_reader.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

using nlohmann::json;

class RecorderTest : public testing::Test {
 protected:
  RecorderTest() {
    config_.record.directory = folder_;
    recorder_.emplace(config_, pipeline_, frames_, events_);
  }
  ~RecorderTest() override { std::filesystem::remove_all(folder_); }

  /// Makes the recorder's turns until it has answered.
  RecordReport answer(const std::function<void(Recorder::Done)>& ask) {
    std::optional<Result<RecordReport>> answer;
    ask([&](Result<RecordReport> done) { answer = std::move(done); });
    for (int turn = 0; turn < 1000 && !answer; ++turn) recorder_->do_work();
    EXPECT_TRUE(answer && *answer) << (answer ? answer->error().reason : "no answer");
    return answer && *answer ? **answer : RecordReport{};
  }
  RecordReport start(const CameraSettings& camera) {
    return answer([&](Recorder::Done done) {
      recorder_->start({{"run", 1, {}, {}}, "{}", camera, {}, "test"}, std::move(done));
    });
  }
  RecordReport stop() {
    return answer([&](Recorder::Done done) { recorder_->stop(std::move(done)); });
  }
  std::unique_ptr<RecordingReader> file() const {
    return std::move(RecordingReader::open(folder_ + "/run.h5").value());
  }

  const std::string folder_ = own_folder("recorder");
  Config config_;
  StreamQueue queue_;
  Events events_{queue_};
  Counters counters_;
  LatestValue<ShownHologram> shown_;
  LatestValue<AppliedSettings> settings_;
  Pipeline pipeline_{PipelineConfig{}, {counters_, shown_, settings_}};
  FrameTaps frames_;
  std::optional<Recorder> recorder_;
};

TEST_F(RecorderTest, DocumentsOfALoopDoNotFillTheMemoryWhileTheDiskStandsStill) {
  constexpr int kMany = 40, kFit = 15;  // of a MiB each, and some kB of others
  ASSERT_EQ(start({}).state, "recording");
  std::int64_t t_closed_ns = 0;
  LoopLog log([&](std::string kind, json content) {
    t_closed_ns = content["t_closed_ns"];
    recorder_->add_loop(std::move(kind), std::move(content));
  });
  log.closed({}, {}, nullptr);
  for (int k = 0; k < kMany; ++k) {
    recorder_->add_loop("loop_steps", {{"t_closed_ns", t_closed_ns},
                                       {"frames", json::array()},
                                       {"more", std::string(std::size_t{1} << 20, 'x')}});
  }
  recorder_->add_loop("loop_steps", {{"t_closed_ns", t_closed_ns}, {"frames", json::array()}});
  log.closed({}, {}, nullptr);  // the next run starts again
  const RecordReport ended = stop();
  EXPECT_EQ(ended.documents_dropped, std::uint64_t(kMany + 1 - kFit));
  auto reader = file();
  EXPECT_EQ(reader->documents_dropped(), ended.documents_dropped);
  const auto documents = reader->documents().value();
  const auto count = [&](const char* kind) {
    return std::ranges::count(documents, kind, &RecordedText::kind);
  };
  EXPECT_EQ(count("loop_steps"), kFit);
  EXPECT_EQ(count("loop"), 2);
  const auto played = replay_loop(*reader);
  ASSERT_TRUE(played) << played.error().reason;
  EXPECT_NE(played->reason.find("documents of the loop are not in the recording"),
            std::string::npos)
      << played->reason;
}

/// The plans of the frames that wait are the oldest.
TEST_F(RecorderTest, PlansDoNotFillTheMemoryWhileTheDiskStandsStill) {
  constexpr std::uint64_t kMany = 100;  // of a MiB each
  ASSERT_EQ(start({}).state, "recording");
  MeasurementPlan plan;
  plan.predicted_px.resize((std::size_t{1} << 20) / sizeof(Vec2));
  plan.reconstructor = std::make_shared<const Reconstructor>(Eigen::MatrixXd::Ones(2, 1),
                                                             std::vector{3}, std::vector<Vec2>());
  for (plan.id = 1; plan.id <= kMany; ++plan.id) {
    recorder_->add_plan(plan, std::make_shared<const SensorSnapshot>());
  }
  const std::uint64_t dropped = stop().documents_dropped;
  EXPECT_GE(dropped, kMany - (Recorder::kMaxFactsBytes >> 20));
  EXPECT_LT(dropped, kMany / 2);
  EXPECT_EQ(file()->documents_dropped(), dropped);
}

TEST_F(RecorderTest, WhatWasDroppedBeforeIsNotCountedAndRoomIsGivenBack) {
  CameraSettings camera;
  CameraInfo info;
  info.vendor.assign(std::size_t{1} << 20, 'x');
  const auto change = [&](int times) {
    for (int k = 0; k < times; ++k) {
      camera.exposure_us += 1.0;
      recorder_->camera_changed(camera, info);
    }
  };
  change(20);  // nothing is recorded, but the thread is busy with something else
  ASSERT_EQ(start(camera).state, "recording");
  change(3);
  EXPECT_EQ(stop().documents_dropped, 0U);
}

TEST_F(RecorderTest, ARunOfTheLoopThatWasCutBeforeIsNotCounted) {
  const auto steps = [&](int times) {
    for (int k = 0; k < times; ++k) {
      recorder_->add_loop("loop_steps", {{"more", std::string(std::size_t{1} << 20, 'x')}});
    }
  };
  steps(20);  // nothing is recorded, but the thread is busy with something else
  ASSERT_EQ(start({}).state, "recording");
  steps(3);
  EXPECT_EQ(stop().documents_dropped, 0U);
}

TEST_F(RecorderTest, OtherLostDocumentsDoNotKeepALoopFromBeingRepeated) {
  CameraSettings camera;
  ASSERT_EQ(start(camera).state, "recording");
  LoopLog log([&](std::string kind, json content) {
    recorder_->add_loop(std::move(kind), std::move(content));
  });
  log.closed({}, {}, nullptr);
  CameraInfo info;
  info.vendor.assign(std::size_t{1} << 20, 'x');
  for (int k = 0; k < 20; ++k) {
    camera.exposure_us += 1.0;
    recorder_->camera_changed(camera, info);
  }
  EXPECT_GT(stop().documents_dropped, 0U);
  const auto played = replay_loop(*file());
  ASSERT_TRUE(played) << played.error().reason;
  EXPECT_EQ(played->runs, 1);
  EXPECT_EQ(played->reason, "");
}

}  // namespace
}  // namespace ovws
