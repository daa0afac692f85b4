#include "daemon/ovwsd/frames/frame_grabs.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <vector>

#include "core/pipeline/plan.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kHourNs = 3'600'000'000'000;  // no test takes as long

TEST(FrameGrabsTest, AnExposureThatMayHaveBegunBeforeTheRequestIsNotTaken) {
  const MeasurementPlan plan;
  const std::array<std::byte, 4> pixels{};
  FrameTaps taps;
  FrameGrabs grabs(taps, [] { return 1; });
  std::vector<std::uint64_t> taken;
  CameraGrab wish;
  wish.timeout_s = 600.0;
  grabs.grab(wish, [&taken](const Result<GrabReport>& grabbed, const FrameGrabs::Pixels&) {
    ASSERT_TRUE(grabbed);
    for (const GrabStamp& stamp : grabbed->frames) taken.push_back(stamp.frame_id);
  });
  const std::int64_t asked_ns = monotonic_ns();

  FrameRecord record;
  record.plan = &plan;
  record.frame.image.data = pixels.data();
  record.frame.image.width = 4;
  record.frame.image.height = 1;
  record.frame.image.stride_bytes = 4;
  record.settings_known = true;
  record.exposure_us = 1e-3 * double(kHourNs);
  record.transfer_ns = 2 * kHourNs;  // the exposure ended from 1 hour before to 1 hour after
  for (const std::int64_t earliest_begin_ns : {asked_ns - kHourNs / 2, asked_ns + 1}) {
    ++record.frame.frame_id;
    record.t_exposed_mono_ns = earliest_begin_ns + kHourNs + record.transfer_ns / 2;
    taps.serve_pixels(record);
  }
  grabs.end_due();
  EXPECT_EQ(taken, (std::vector<std::uint64_t>{2}));
}

}  // namespace
}  // namespace ovws
