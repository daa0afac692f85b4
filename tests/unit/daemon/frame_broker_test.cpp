#include "daemon/ovwsd/frames/frame_broker.hpp"

#include <gtest/gtest.h>

#include <new>
#include <thread>

#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/frames/measured_under.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;
using Needs = FrameBroker::Needs;

class FrameBrokerTest : public testing::Test {
 protected:
  /// A request for `frames` frames that notes the numbers of those which it used.
  std::unique_ptr<FrameBroker::Request> request(Needs needs, int frames) {
    return broker_.request(needs, frames, [this](const FrameRecord& record) {
      seen_.push_back(record.frame.frame_id);
      return usable_;
    });
  }
  const FrameRecord& next() {
    ++record_.frame.frame_id;
    return record_;
  }

  FrameBroker broker_;
  FrameRecord record_;
  bool usable_ = true;
  std::vector<std::uint64_t> seen_;
};

TEST_F(FrameBrokerTest, ServesTheNextFramesAndNoMore) {
  broker_.serve_numbers(next());  // before anything is requested
  const auto open = request(Needs::numbers, 2);
  for (int k = 0; k < 3; ++k) broker_.serve_numbers(next());
  EXPECT_EQ(seen_, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_TRUE(open->done());
  EXPECT_TRUE(open->wait_for(0ms));
}

TEST_F(FrameBrokerTest, CountsOnlyTheFramesThatAreUsed) {
  const auto open = request(Needs::numbers, 1);
  usable_ = false;
  for (int k = 0; k < 5; ++k) broker_.serve_numbers(next());
  EXPECT_EQ(open->used(), 0);
  EXPECT_FALSE(open->wait_for(1ms));
  EXPECT_GT(open->idle_s(), 0.0);
  usable_ = true;
  broker_.serve_numbers(next());
  EXPECT_EQ(seen_.size(), 6U);
  EXPECT_TRUE(open->done());
}

TEST_F(FrameBrokerTest, ARequestForPixelsIsServedWithPixelsOnly) {
  EXPECT_FALSE(broker_.wants_pixels());
  const auto open = request(Needs::pixels, 1);
  EXPECT_TRUE(broker_.wants_pixels());
  broker_.serve_numbers(next());
  EXPECT_TRUE(seen_.empty());
  broker_.serve_pixels(next());
  EXPECT_EQ(seen_.size(), 1U);
  EXPECT_FALSE(broker_.wants_pixels());
}

TEST_F(FrameBrokerTest, ADestroyedRequestIsNotServed) {
  { const auto open = request(Needs::pixels, 3); }
  EXPECT_FALSE(broker_.wants_pixels());
  broker_.serve_pixels(next());
  EXPECT_TRUE(seen_.empty());
}

TEST_F(FrameBrokerTest, ServesSeveralRequestsWithOneFrame) {
  const auto first = request(Needs::numbers, 1), second = request(Needs::numbers, 2);
  broker_.serve_numbers(next());
  broker_.serve_numbers(next());
  EXPECT_EQ(seen_, (std::vector<std::uint64_t>{1, 1, 2}));
}

TEST_F(FrameBrokerTest, ARequestStaysOpenWhenMemoryRunsOut) {
  bool memory = false;
  const auto open = broker_.request(Needs::pixels, 1, [&](const FrameRecord& /*record*/) {
    if (!memory) throw std::bad_alloc();
    return true;
  });
  EXPECT_THROW(broker_.serve_pixels(next()), std::bad_alloc);
  memory = true;
  broker_.serve_pixels(next());
  EXPECT_TRUE(open->done());
}

/// The publish thread serves while others request, look and withdraw.
TEST_F(FrameBrokerTest, IsUsedFromManyThreads) {
  std::atomic<bool> end{false};
  std::thread publisher([&] {
    FrameRecord record;
    while (!end) {
      ++record.frame.frame_id;
      broker_.serve_numbers(record);
    }
  });
  const auto requester = [this] {
    for (int round = 0; round < 200; ++round) {
      std::vector<std::uint64_t> ids;
      const auto open = broker_.request(Needs::numbers, 20, [&ids](const FrameRecord& record) {
        ids.push_back(record.frame.frame_id);
        return true;
      });
      if (round % 2 == 0) continue;  // withdrawn at once
      ASSERT_TRUE(open->wait_for(10s));
      ASSERT_EQ(ids.size(), 20U);
      for (std::size_t k = 1; k < ids.size(); ++k) ASSERT_EQ(ids[k], ids[k - 1] + 1);
    }
  };
  std::thread other(requester);
  requester();
  other.join();
  end = true;
  publisher.join();
}

TEST_F(FrameBrokerTest, AFailingRequestTakesNoFrameFromTheOthers) {
  const auto failing = broker_.request(
      Needs::pixels, 1, [](const FrameRecord& /*record*/) -> bool { throw std::bad_alloc(); });
  const auto other = request(Needs::pixels, 1);
  EXPECT_THROW(broker_.serve_pixels(next()), std::bad_alloc);
  EXPECT_TRUE(other->done());
  EXPECT_FALSE(failing->done());
}

class MeasuredTest : public testing::Test {
 protected:
  MeasuredTest() {
    plan_.sensor_epoch = 5;
    record_.plan = &plan_;
    record_.hologram_id = 9;
    record_.settled = record_.still = record_.settings_known = true;
  }
  const MeasuredUnder under_{5, 9};
  MeasurementPlan plan_;
  FrameRecord record_;
};

TEST_F(MeasuredTest, TakesTheFramesOfThisSensorAndHologram) {
  EXPECT_TRUE(under_.settled(record_));
  EXPECT_TRUE(under_.still(record_));
}

TEST_F(MeasuredTest, TakesNoFrameOfAnythingElse) {
  MeasurementPlan other_epoch;
  other_epoch.sensor_epoch = 6;
  std::vector<FrameRecord> others(4, record_);
  others[0].plan = &other_epoch;
  others[1].hologram_id = 8;
  others[2].settled = others[2].still = false;
  for (int k = 0; k < 3; ++k) {
    EXPECT_FALSE(under_.settled(others[std::size_t(k)])) << k;
    EXPECT_FALSE(under_.still(others[std::size_t(k)])) << k;
  }
  others[3].settings_known = false;
  EXPECT_TRUE(under_.settled(others[3]));
  EXPECT_FALSE(under_.still(others[3]));
}

TEST(FrameCopy, ShowsItsOwnPixelsWhenItIsCopied) {
  FrameCopy frame;
  frame.pixels = {std::byte{1}, std::byte{2}};
  frame.image.data = frame.pixels.data();
  const FrameCopy copy = copy_of(frame);
  frame.pixels[0] = std::byte{7};  // the inbox's next frame
  EXPECT_EQ(copy.image.data, copy.pixels.data());
  EXPECT_EQ(copy.image.data[0], std::byte{1});
}

}  // namespace
}  // namespace ovws
