/// Frames through the whole pipeline: order, gaps, accounting, verdicts, buffers and images.
#include "core/pipeline/pipeline.hpp"

#include <gtest/gtest.h>

#include "core/port/clock.hpp"
#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

/// A rig with a plan in use and the camera attached.
struct Running : PipelineRig {
  explicit Running(int workers = 0, int records = 64, int buffers = 8)
      : PipelineRig(workers, records, buffers) {
    use(bench.plan(1));
    EXPECT_TRUE(attach());
    still = SpotBench::draw(bench.model_px);
  }
  std::shared_ptr<const Image<std::uint8_t>> still;
};

TEST(Pipeline, RecoversTheWavefrontThatItsSpotsWereDrawnWith) {
  Running rig;
  const std::vector<Mode> truth{{3, 0.4}, {4, -0.3}, {8, 0.15}};
  Taken record(rig, rig.measure(1, SpotBench::draw(rig.bench.moved(truth))));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->tracked, 19);
  EXPECT_TRUE(record->valid);
  ASSERT_EQ(record->mode_count, int(rig.bench.modes_j.size()));
  for (int m = 0; m < record->mode_count; ++m) {
    double expected = 0.0;
    for (const Mode& mode : truth) expected += mode.j == m + 1 ? mode.waves : 0.0;
    EXPECT_NEAR(double(record->coefficients[std::size_t(m)]), expected, 0.01) << "j " << m + 1;
  }
  EXPECT_LT(record->reconstruction.fit_residual_px, 0.2);
}

TEST(Pipeline, AFrameOfPositionsWaitsForTemplatesIfPositionsDoNotDetermineAllModes) {
  PipelineRig rig;
  auto plan = rig.bench.plan(1);
  const std::size_t determined = plan->modes_j.size();
  plan->modes_j.push_back(plan->modes_j.back() + 1);
  rig.use(std::move(plan));
  ASSERT_TRUE(rig.attach());
  Taken record(rig, rig.measure(1, SpotBench::draw(rig.bench.moved({{4, 0.3}}))));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->mode_count, int(determined) + 1);
  EXPECT_NEAR(record->coefficients[3], 0.3F, 0.01F);
  EXPECT_TRUE(std::isnan(record->coefficients[determined]));
  EXPECT_TRUE(record->unconfirmed);
  EXPECT_FALSE(record->valid);
}

TEST(Pipeline, FramesComeOutInOrderAndNoneIsMissing) {
  Running rig;
  for (std::uint64_t id = 1; id <= 20; ++id) rig.send(id, rig.still);
  for (int i = 0; i < 20; ++i) rig.turn();
  for (std::uint64_t id = 1; id <= 20; ++id) {
    Taken record(rig, rig.pipeline.next(0));
    ASSERT_TRUE(record);
    EXPECT_EQ(record->frame.frame_id, id);
    EXPECT_EQ(record->gap, 0U);
  }
  EXPECT_EQ(rig.pipeline.next(0), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_published), 20U);
  EXPECT_EQ(rig.count(Counter::frames_invalid), 0U);
}

TEST(Pipeline, GapsAreCountedFromTheCamerasNumbers) {
  Running rig;
  EXPECT_EQ(Taken(rig, rig.measure(5, rig.still))->gap, 0U);  // the first of a stream
  EXPECT_EQ(Taken(rig, rig.measure(6, rig.still))->gap, 0U);
  EXPECT_EQ(Taken(rig, rig.measure(10, rig.still))->gap, 3U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 3U);
}

TEST(Pipeline, OfAGapOnlyWhatWasNotIncompleteIsLost) {
  Running rig;
  Taken(rig, rig.measure(1, rig.still));
  rig.camera.send({2, 0, nullptr, true});
  rig.turn();
  EXPECT_EQ(Taken(rig, rig.measure(3, rig.still))->gap, 1U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 0U);
  EXPECT_EQ(rig.count(Counter::frames_grabbed), 2U);
  rig.camera.send({5, 0, nullptr, true});
  rig.turn();
  EXPECT_EQ(Taken(rig, rig.measure(7, rig.still))->gap, 3U);
  EXPECT_EQ(rig.count(Counter::frames_incomplete), 2U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 2U);
  EXPECT_EQ(Taken(rig, rig.measure(9, rig.still))->gap, 1U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 3U);
}

TEST(Pipeline, AFrameThatComesAgainOrTooLateIsCountedAndNotTracked) {
  Running rig;
  Taken(rig, rig.measure(200, rig.still));
  EXPECT_EQ(rig.measure(200, rig.still), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_duplicated), 1U);
  Taken(rig, rig.measure(202, rig.still));
  EXPECT_EQ(rig.measure(201, rig.still), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_out_of_order), 1U);
  EXPECT_EQ(Taken(rig, rig.measure(203, rig.still))->gap, 0U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 1U);
  EXPECT_EQ(rig.count(Counter::frames_grabbed), 3U);
  EXPECT_EQ(Taken(rig, rig.measure(3, rig.still))->frame.frame_id, 3U);  // numbers restart
}

TEST(Pipeline, FramesThatTheDriverThrewAwayAreCountedByTheirNames) {
  Running rig;
  Taken(rig, rig.measure(1, rig.still));
  for (const GrabStatus status :
       {GrabStatus::duplicate, GrabStatus::out_of_order, GrabStatus::duplicate}) {
    rig.camera.send({0, 0, nullptr, false, PixelFormat::mono8, 0, status});
    rig.turn();
  }
  EXPECT_EQ(rig.count(Counter::frames_duplicated), 2U);
  EXPECT_EQ(rig.count(Counter::frames_out_of_order), 1U);
  EXPECT_EQ(rig.count(Counter::frames_grabbed), 1U);
}

TEST(Pipeline, AFrameThatArrivesMuchLaterThanTheTransferMayTakeIsNotSettled) {
  Running rig;
  rig.applied.frame_rate_hz = 50.0;
  rig.applied.transfer_ns = 10 * kMs;
  rig.settings.write(rig.applied);
  const auto held_up = [&rig](std::uint64_t id, std::int64_t by_ns, bool stamped) {
    const std::int64_t arrival = rig.arrival_ns(id);
    rig.camera.send({id, arrival + by_ns, rig.still, false, PixelFormat::mono8,
                     stamped ? arrival - 900 * kMs : 0});
    rig.turn();
    Taken record(rig, rig.pipeline.next(0));
    EXPECT_EQ(record->settled, record->valid);
    return record->settled;
  };
  EXPECT_TRUE(held_up(10, 0, true));
  EXPECT_TRUE(held_up(11, 70 * kMs, true));  // the transfer and three periods
  EXPECT_FALSE(held_up(12, 70 * kMs + 1, true));
  EXPECT_EQ(rig.count(Counter::frames_late), 1U);
  EXPECT_TRUE(held_up(13, 0, true));
  EXPECT_TRUE(held_up(16, 80 * kMs, false));  // no stamp: the arrival is all that is known
  EXPECT_EQ(rig.count(Counter::frames_late), 1U);
}

TEST(Pipeline, ANewStreamBeginsWithoutAGap) {
  Running rig;
  Taken(rig, rig.measure(100, rig.still));
  ASSERT_TRUE(rig.detach());
  ASSERT_TRUE(rig.attach());
  EXPECT_EQ(Taken(rig, rig.measure(1, rig.still))->gap, 0U);
  ASSERT_TRUE(rig.detach());
  ASSERT_TRUE(rig.attach());
  EXPECT_EQ(Taken(rig, rig.measure(500, rig.still))->gap, 0U);
  EXPECT_EQ(rig.count(Counter::frames_lost), 0U);
}

TEST(Pipeline, WithoutAPlanFramesAreCountedAndTheCameraNeverStarves) {
  PipelineRig rig(0, 64, 2);
  ASSERT_TRUE(rig.attach());
  for (std::uint64_t id = 1; id <= 10; ++id)
    EXPECT_EQ(rig.measure(id, SpotBench::black()), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_unplanned), 10U);
  EXPECT_EQ(rig.camera.lent(), 0);
}

TEST(Pipeline, AFrameOfAnotherSizeOrFormatIsNotTracked) {
  Running rig;
  const auto small = std::make_shared<Image<std::uint8_t>>(SpotBench::kSize, 100);
  EXPECT_EQ(rig.measure(1, small), nullptr);
  rig.camera.send({2, rig.arrival_ns(2), rig.still, false, PixelFormat::mono12});
  rig.turn();
  EXPECT_EQ(rig.pipeline.next(0), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_unexpected), 2U);
  EXPECT_EQ(rig.camera.lent(), 0);
  EXPECT_EQ(Taken(rig, rig.measure(3, rig.still))->tracked, 19);
}

TEST(Pipeline, EveryGrabbedFrameIsAccountedFor) {
  for (const int workers : {0, 2}) {
    PipelineRig rig(workers, 8);
    ASSERT_TRUE(rig.attach());
    const auto still = SpotBench::draw(rig.bench.model_px);
    rig.measure(1, still);  // unplanned
    rig.use(rig.bench.plan(1));
    rig.measure(2, std::make_shared<Image<std::uint8_t>>(10, 10));  // unexpected
    for (std::uint64_t id = 3; id <= 30; ++id) {                    // published, then dropped
      rig.send(id, still);
      rig.turn();
    }
    int published = 0;
    while (FrameRecord* record = rig.pipeline.next(0)) {
      rig.pipeline.release(record);
      ++published;
    }
    EXPECT_EQ(rig.count(Counter::frames_grabbed), 30U);
    EXPECT_EQ(rig.count(Counter::frames_unplanned), 1U);
    EXPECT_EQ(rig.count(Counter::frames_unexpected), 1U);
    EXPECT_EQ(rig.count(Counter::frames_published), std::uint64_t(published));
    EXPECT_EQ(published, 6);  // three quarters of 8
    EXPECT_EQ(rig.count(Counter::frames_dropped), 22U);
  }
}

TEST(Pipeline, WhileThePublisherIsSlowTheTracksGoOn) {
  Running rig(0, 8);
  const auto at = [&](std::uint64_t id) {  // walks farther than a pitch in all
    return SpotBench::draw(rig.bench.moved({}, {3.0 * double(id) - 50.0, 0.0}));
  };
  for (std::uint64_t id = 1; id <= 30; ++id) {
    rig.send(id, at(id));
    rig.turn();
  }
  EXPECT_EQ(rig.count(Counter::frames_dropped), 24U);
  while (FrameRecord* record = rig.pipeline.next(0)) rig.pipeline.release(record);
  Taken record(rig, rig.measure(31, at(31)));
  ASSERT_TRUE(record);
  EXPECT_EQ(record->gap, 24U);
  EXPECT_EQ(record->tracked, 19);
  EXPECT_NEAR(double(record->spots[0].x), rig.bench.model_px[0].x + 43.0, 0.5);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
  EXPECT_EQ(rig.count(Counter::spots_lost), 0U);
}

TEST(Pipeline, WithTheTrackersStoppedFramesAreDroppedAndTheirBuffersStayCounted) {
  Running rig(1, 4, 8);
  for (std::uint64_t id = 1; id <= 7; ++id) rig.send(id, rig.still);
  for (int i = 0; i < 7; ++i) rig.pipeline.acquisition().do_work();
  EXPECT_EQ(rig.count(Counter::frames_dropped), 3U);
  EXPECT_EQ(rig.camera.lent(), 4);
  EXPECT_TRUE(rig.detach());
  EXPECT_EQ(rig.camera.lent(), 0);
}

TEST(Pipeline, InlineNoBufferStaysLentBetweenFrames) {
  Running rig;
  Taken record(rig, rig.measure(1, rig.still));
  EXPECT_EQ(rig.camera.lent(), 0);
}

TEST(Pipeline, DetachReturnsAllBuffersAndAttachGoesOn) {
  for (const int workers : {0, 3}) {
    Running rig(workers);
    for (std::uint64_t id = 1; id <= 6; ++id) rig.send(id, rig.still);
    for (int i = 0; i < 6; ++i) rig.pipeline.acquisition().do_work();
    ASSERT_TRUE(rig.detach());
    EXPECT_EQ(rig.camera.lent(), 0);
    EXPECT_EQ(rig.pipeline.last_frame_mono_ns(), 0);
    while (FrameRecord* record = rig.pipeline.next(0)) rig.pipeline.release(record);
    rig.send(7, rig.still);
    rig.turn();
    EXPECT_FALSE(rig.camera.all_sent());  // nobody grabs from a detached camera
    ASSERT_TRUE(rig.attach());
    while (!rig.camera.all_sent()) rig.turn();
    EXPECT_EQ(rig.pipeline.last_frame_mono_ns(), rig.arrival_ns(7));
  }
}

TEST(Pipeline, AnImageRequestLendsOneBufferUntilItIsGivenBack) {
  for (const int workers : {0, 2}) {
    Running rig(workers);
    Taken(rig, rig.measure(1, rig.still));
    EXPECT_EQ(rig.pipeline.next_image(0), nullptr);
    rig.pipeline.request_image();
    Taken(rig, rig.measure(2, rig.still));
    Taken(rig, rig.measure(3, rig.still));
    FrameRecord* const image = rig.pipeline.next_image(0);
    ASSERT_NE(image, nullptr);
    EXPECT_EQ(rig.pipeline.next_image(0), nullptr);
    EXPECT_EQ(image->frame.frame_id, 2U);
    EXPECT_EQ(image->tracked, 19);
    rig.turn();
    EXPECT_EQ(rig.camera.lent(), 1);
    const auto x = int(std::lround(rig.bench.model_px[0].x));
    const auto y = int(std::lround(rig.bench.model_px[0].y));
    EXPECT_GT(int(image->frame.image.row<std::uint8_t>(y)[x]), 190);
    rig.pipeline.release_image(image);
    rig.turn();
    EXPECT_EQ(rig.camera.lent(), 0);
  }
}

TEST(Pipeline, AnImageIsDeliveredEvenWhenThePublisherIsTooSlowForItsFrame) {
  Running rig(0, 4);
  for (std::uint64_t id = 1; id <= 3; ++id) rig.send(id, rig.still), rig.turn();
  rig.pipeline.request_image();
  rig.send(4, rig.still), rig.turn();
  EXPECT_EQ(rig.count(Counter::frames_dropped), 1U);
  FrameRecord* const image = rig.pipeline.next_image(0);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->frame.frame_id, 4U);
  rig.pipeline.release_image(image);
  while (FrameRecord* record = rig.pipeline.next(0)) rig.pipeline.release(record);
}

TEST(Pipeline, AllBuffersLentMeansWaitingNotLosingTrack) {
  Running rig(0, 64, 1);
  rig.pipeline.request_image();
  Taken(rig, rig.measure(1, rig.still));
  FrameRecord* const image = rig.pipeline.next_image(0);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(rig.measure(2, rig.still), nullptr);
  rig.pipeline.release_image(image);
  rig.turn();
  EXPECT_EQ(Taken(rig, rig.pipeline.next(0))->frame.frame_id, 2U);
}

TEST(Pipeline, AFrameWhileTheHologramChangesIsPublishedInvalid) {
  Running rig;
  Taken(rig, rig.measure(1, rig.still));
  rig.show({2, 1, rig.arrival_ns(2) - kMs / 2, rig.arrival_ns(4)}, {1, 1, 0, kMs});
  Taken record(rig, rig.measure(2, rig.still));
  EXPECT_FALSE(record->settled);
  EXPECT_FALSE(record->valid);
  EXPECT_EQ(record->hologram_id, 2U);
  EXPECT_EQ(record->tracked, 19);
  EXPECT_EQ(rig.count(Counter::frames_unsettled), 1U);
  EXPECT_EQ(rig.count(Counter::frames_invalid), 1U);
}

TEST(Pipeline, WithoutAReferenceNothingIsValid) {
  PipelineRig rig;
  auto plan = rig.bench.plan(1);
  plan->reference_px.clear();  // although the reconstructor would determine the modes
  rig.use(std::move(plan));
  ASSERT_TRUE(rig.attach());
  Taken record(rig, rig.measure(1, SpotBench::draw(rig.bench.model_px)));
  EXPECT_TRUE(record->settled);
  EXPECT_EQ(record->tracked, 19);
  EXPECT_TRUE(record->reconstruction.determined);
  EXPECT_FALSE(record->valid);
}

TEST(Pipeline, ARecordCarriesTheSettingsOfItsOwnFrame) {
  Running rig;
  rig.applied.gain_db = 12.0;
  rig.applied.exposure_us = 2000.0;
  rig.applied.previous_gain_db = 3.0;
  rig.applied.previous_exposure_us = 1000.0;
  rig.applied.t_write_begin_mono_ns = rig.arrival_ns(2);
  rig.applied.t_write_end_mono_ns = rig.arrival_ns(3);
  rig.settings.write(rig.applied);
  Taken before(rig, rig.measure(2, rig.still));
  Taken meanwhile(rig, rig.measure(3, rig.still));
  Taken after(rig, rig.measure(4, rig.still));
  EXPECT_TRUE(before->settings_known);
  EXPECT_EQ(before->gain_db, 3.0);
  EXPECT_EQ(before->exposure_us, 1000.0);
  EXPECT_FALSE(meanwhile->settings_known);
  EXPECT_TRUE(after->settings_known);
  EXPECT_EQ(after->gain_db, 12.0);
  EXPECT_EQ(after->exposure_us, 2000.0);
}

TEST(Pipeline, SaturatedIsTheFractionOfSpotsWithAFullPixel) {
  Running rig;
  EXPECT_EQ(Taken(rig, rig.measure(1, rig.still))->saturated_fraction, 0.0F);
  const auto bright = SpotBench::draw(rig.bench.model_px, {0, 1, 2, 3}, 300.0);
  EXPECT_FLOAT_EQ(Taken(rig, rig.measure(2, bright))->saturated_fraction, 15.0F / 19.0F);
}

TEST(Pipeline, AFrameThatTookLongerThanItsPeriodMissedItsDeadline) {
  Running rig;
  rig.applied.frame_rate_hz = 100.0;
  rig.settings.write(rig.applied);
  const std::int64_t now = monotonic_ns();
  rig.camera.send({1, now - 1000 * kMs, rig.still});
  rig.turn();
  EXPECT_EQ(rig.count(Counter::deadline_missed), 1U);
  rig.camera.send({2, now + 3'600'000 * kMs, rig.still});
  rig.turn();
  EXPECT_EQ(rig.count(Counter::deadline_missed), 1U);
  EXPECT_EQ(rig.pipeline.latencies().tracked.take().count, 2U);
  EXPECT_EQ(rig.pipeline.latencies().reconstructed.take().count, 2U);
  while (FrameRecord* record = rig.pipeline.next(0)) rig.pipeline.release(record);
}

TEST(Pipeline, HowLongAFrameWasDelayedIsReportedIfTheCameraStampsIt) {
  Running rig;
  const std::int64_t now = monotonic_ns();
  for (int k = 1; k <= 3; ++k) {  // every 10 ms by the camera's clock, the third held up for 40 ms
    const std::int64_t arrival = now + (k * 10 + (k == 3 ? 40 : 0)) * kMs;
    rig.camera.send(
        {std::uint64_t(k), arrival, rig.still, false, PixelFormat::mono8, (7000 + k * 10) * kMs});
    rig.turn();
  }
  rig.camera.send({4, now + 90 * kMs, rig.still});
  rig.turn();
  const LatencySummary arrived = rig.pipeline.latencies().arrived.take();
  EXPECT_EQ(arrived.count, 3U);
  EXPECT_EQ(arrived.max_us, 40e3);
  EXPECT_LT(arrived.p50_us, 1.0);
  while (FrameRecord* record = rig.pipeline.next(0)) rig.pipeline.release(record);
}

}  // namespace
}  // namespace ovws::test
