#include "daemon/ovwsd/actor/state_keeper.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

class StateKeeperTest : public testing::Test {
 protected:
  StateKeeperTest() {
    state_.set(&Conditions::started, true);
    state_.set(&Conditions::camera, true);
  }
  StreamQueue queue_;
  Events events_{queue_};
  StateKeeper state_{events_};
};

TEST_F(StateKeeperTest, AFaultLastsUntilTheLastOfItsCausesIsGone) {
  state_.set_fault("slm", "the mode is wrong");
  state_.set_fault("camera", "no such format");
  EXPECT_EQ(state_.name(), "fault");
  EXPECT_EQ(state_.fault(), "camera: no such format; slm: the mode is wrong");
  state_.set_fault("slm", "");
  EXPECT_EQ(state_.name(), "fault");
  state_.set_fault("camera", "");
  EXPECT_EQ(state_.name(), "waiting_for_display");
  EXPECT_EQ(state_.fault(), std::nullopt);
}

TEST_F(StateKeeperTest, EachChangeOfStateIsOneEventAndRepetitionIsNone) {
  while (queue_.take()) {
  }
  for (int i = 0; i < 3; ++i) state_.set_fault("slm", "the mode is wrong");
  state_.set_fault("slm", "");
  state_.set(&Conditions::display, true);
  std::string reported;
  while (const auto message = queue_.take()) {
    reported += std::get<EventMessage>(*message).data["state"].get<std::string>() + " ";
  }
  EXPECT_EQ(reported, "fault waiting_for_display running ");
}

}  // namespace
}  // namespace ovws
