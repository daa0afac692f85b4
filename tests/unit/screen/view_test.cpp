/// Which messages count as the bench's state.
#include "daemon/ovws/screen/view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/screen/example.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

class GathererTest : public testing::Test {
 protected:
  void take(const std::string& topic, const json& message) {
    gatherer_.take(topic, message.dump(), {}, now_);
  }
  void take_counter(const std::string& name, std::uint64_t count) {
    json status = example("status");
    status["counters"] = {{name, count}};
    take("status", status);
  }
  const View& view() { return gatherer_.view(now_); }

  Clock::time_point now_ = Clock::now();
  Gatherer gatherer_{now_};
};

TEST_F(GathererTest, KnowsNothingAtFirst) {
  EXPECT_FALSE(view().status_is_current);
  EXPECT_TRUE(view().status.is_null());
  EXPECT_TRUE(view().wavefront.is_null());
}

TEST_F(GathererTest, ShowsTheNewestOnly) {
  take("status", example("status"));
  json frame = example("wavefront");
  for (int id = 1; id <= 3; ++id) {
    frame["frame_id"] = id;
    take("wavefront", frame);
  }
  EXPECT_EQ(view().wavefront.at("frame_id"), 3);
  EXPECT_EQ(view().wavefront.at("frame_id"), 3) << "and again";
}

TEST_F(GathererTest, WhatIsOldIsNotShown) {
  take("status", example("status"));
  take("wavefront", example("wavefront"));
  now_ += 2900ms;
  EXPECT_TRUE(view().status_is_current);
  EXPECT_FALSE(view().wavefront.is_null());
  take("status", example("status"));
  now_ += 200ms;
  EXPECT_FALSE(view().status.is_null());
  EXPECT_TRUE(view().wavefront.is_null()) << "the daemon goes on, frames do not";
  now_ += 3s;
  EXPECT_FALSE(view().status_is_current);
  EXPECT_TRUE(view().status.is_null());
  EXPECT_NEAR(view().silent_s, 3.2, 1e-6);
}

TEST_F(GathererTest, SlowFramesAreWaitedFor) {
  json status = example("status");
  status["camera"]["settings"]["frame_rate_hz"] = 0.1;
  take("wavefront", example("wavefront"));
  now_ += 29s;
  take("status", status);
  EXPECT_FALSE(view().wavefront.is_null());
}

TEST_F(GathererTest, LossesAreTheCountersThatAreNotZeroAndHowTheyGrow) {
  take_counter("frames_lost", 0);
  EXPECT_TRUE(view().losses.empty());
  take_counter("frames_lost", 7);
  ASSERT_EQ(view().losses.size(), 1U);
  EXPECT_EQ(view().losses[0].name, "frames_lost");
  EXPECT_EQ(view().losses[0].grown, 7U);
  take_counter("frames_lost", 7);
  EXPECT_EQ(view().losses[0].grown, 0U);
  take_counter("frames_lost", 2);
  EXPECT_EQ(view().losses[0].count, 2U) << "a daemon that was started anew";
  EXPECT_EQ(view().losses[0].grown, 0U);
  take_counter("requests", 7);
  EXPECT_TRUE(view().losses.empty()) << "not a loss";
}

TEST_F(GathererTest, SpotsAreReadFromTheBinaryPart) {
  const float rows[2][6]{{1, 2, 3, 4, 5, 6}, {NAN, NAN, 9, 10, 0, 0}};
  std::vector<std::byte> binary(sizeof(rows) + 5);  // and a piece that is no row
  std::memcpy(binary.data(), rows, sizeof(rows));
  take("status", example("status"));
  take("wavefront", example("wavefront"));
  gatherer_.take("spots", example("spots").dump(), binary, now_);
  ASSERT_EQ(view().spots.size(), 2U);
  EXPECT_EQ(view().spots[0].ref_y, 4.0F);
  EXPECT_TRUE(std::isnan(view().spots[1].x));
}

TEST_F(GathererTest, EventsAreKeptUpToFifty) {
  json event = example("event");
  for (int k = 0; k < 60; ++k) {
    event["seq"] = k;
    take("event", event);
  }
  EXPECT_EQ(view().events.size(), 50U);
  EXPECT_EQ(view().events.back().at("seq"), 59);
}

TEST_F(GathererTest, AMessageThatIsNoJsonObjectOrOfAnUnknownTopicChangesNothing) {
  take("status", example("status"));
  take("wavefront", example("wavefront"));
  take("event", example("event"));
  for (const char* text : {"", "{", "[]", "3"}) {
    for (const char* topic : {"status", "event", "what"}) {
      SCOPED_TRACE(std::string(topic) + " " + text);
      now_ += 200ms;
      gatherer_.take(topic, text, {}, now_);
      EXPECT_TRUE(view().status_is_current);
      EXPECT_TRUE(view().status == example("status"));
      EXPECT_TRUE(view().wavefront == example("wavefront"));
      EXPECT_EQ(view().events.size(), 1U);
    }
  }
  now_ += 700ms;
  gatherer_.take("status", "{", {}, now_);
  EXPECT_FALSE(view().status_is_current) << "3.1 s after the last one";
}

TEST_F(GathererTest, AWavefrontThatIsNoJsonObjectLeavesNoneToShow) {
  for (const char* text : {"{", "[]", "3"}) {
    take("status", example("status"));
    take("wavefront", example("wavefront"));
    gatherer_.take("wavefront", text, {}, now_);
    EXPECT_TRUE(view().status == example("status")) << text;
    EXPECT_TRUE(view().wavefront.is_null()) << text;
  }
}

TEST_F(GathererTest, AStatusOfAnotherStructureIsKeptWithoutLosses) {
  for (const char* text : {R"({"counters": 5})", R"({"camera": []})"}) {
    take_counter("frames_lost", 7);
    take("wavefront", example("wavefront"));
    gatherer_.take("status", text, {}, now_);
    EXPECT_EQ(view().status, json::parse(text));
    EXPECT_EQ(view().wavefront, example("wavefront")) << text;
    EXPECT_TRUE(view().losses.empty()) << text;
  }
}

}  // namespace
}  // namespace ovws::screen
