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
  void set_camera(bool connected, const std::string& cause) {
    state_.set_device("camera", &Conditions::camera, connected, cause);
  }
  void set_slm(bool connected, const std::string& cause) {
    state_.set_device("slm", &Conditions::display, connected, cause);
  }
  /// The states of the queued events.
  std::string reported() {
    std::string states;
    while (const auto message = queue_.take()) {
      states += std::get<EventMessage>(*message).data["state"].get<std::string>() + " ";
    }
    return states;
  }

  StreamQueue queue_;
  Events events_{queue_};
  StateKeeper state_{events_};
};

TEST_F(StateKeeperTest, AFaultLastsUntilTheLastOfItsCausesIsGone) {
  set_slm(false, "the mode is wrong");
  set_camera(false, "no such format");
  EXPECT_EQ(state_.name(), "fault");
  EXPECT_EQ(state_.fault(), "camera: no such format; slm: the mode is wrong");
  set_slm(false, "");
  EXPECT_EQ(state_.name(), "fault");
  set_camera(true, "");
  EXPECT_EQ(state_.name(), "waiting_for_display");
  EXPECT_EQ(state_.fault(), std::nullopt);
}

TEST_F(StateKeeperTest, EachChangeOfStateIsOneEventAndRepetitionIsNone) {
  (void)reported();
  for (int i = 0; i < 3; ++i) set_slm(false, "the mode is wrong");
  set_slm(false, "");
  set_slm(true, "");
  EXPECT_EQ(reported(), "fault waiting_for_display running ");
}

TEST_F(StateKeeperTest, ADeviceThatRecoversFromItsFaultIsReportedOnce) {
  set_slm(true, "");
  (void)reported();
  set_camera(false, "no such format");
  set_camera(true, "");
  EXPECT_EQ(reported(), "fault running ");
}

}  // namespace
}  // namespace ovws
