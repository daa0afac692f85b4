/// The state machine's tables against an independent list: every state with every event and action.
#include "core/control/state_machine.hpp"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>
#include <vector>

namespace ovws {
namespace {

/// A change of one condition.
struct Event {
  bool Conditions::*condition;
  bool becomes;
};
constexpr Event kStarted{&Conditions::started, true};
constexpr Event kCameraConnected{&Conditions::camera, true},
    kCameraLost{&Conditions::camera, false};
constexpr Event kDisplayConnected{&Conditions::display, true};
constexpr Event kDisplayLost{&Conditions::display, false};
constexpr Event kJobBegun{&Conditions::job, true}, kJobEnded{&Conditions::job, false};
constexpr Event kLoopClosed{&Conditions::loop, true}, kLoopOpened{&Conditions::loop, false};
constexpr Event kFaultRaised{&Conditions::fault, true}, kFaultCleared{&Conditions::fault, false};
constexpr Event kStopRequested{&Conditions::stopping, true};
constexpr std::array kEvents{kStarted,     kCameraConnected, kCameraLost,   kDisplayConnected,
                             kDisplayLost, kJobBegun,        kJobEnded,     kLoopClosed,
                             kLoopOpened,  kFaultRaised,     kFaultCleared, kStopRequested};
constexpr std::size_t kEventCount = kEvents.size();
constexpr std::size_t kActionCount = std::size_t(Action::count);
constexpr std::size_t kStateCount = std::size_t(DaemonState::count);

std::vector<Conditions> all_conditions() {
  std::vector<Conditions> all;
  for (unsigned bits = 0; bits < 2048; ++bits) {
    const auto bit = [bits](unsigned n) { return ((bits >> n) & 1U) != 0; };
    all.push_back(
        {bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), bit(6), bit(7), bit(8), bit(9), bit(10)});
  }
  return all;
}

Conditions after(Conditions conditions, const Event& event) {
  conditions.*event.condition = event.becomes;
  return conditions;
}

Conditions by(std::initializer_list<Event> events) {
  Conditions conditions;
  for (const Event& event : events) conditions = after(conditions, event);
  return conditions;
}

Conditions up() {
  return by({kStarted, kCameraConnected, kDisplayConnected});
}

/// One set of conditions for each state, with everything else in order.
Conditions example(DaemonState state) {
  switch (state) {
    case DaemonState::stopping:
      return after(up(), kStopRequested);
    case DaemonState::starting:
      return {};
    case DaemonState::fault:
      return after(after(up(), kDisplayLost), kFaultRaised);
    case DaemonState::waiting_for_camera:
      return after(up(), kCameraLost);
    case DaemonState::waiting_for_display:
      return after(up(), kDisplayLost);
    case DaemonState::job_running:
      return after(after(up(), kJobBegun), {&Conditions::measuring, true});
    case DaemonState::running:
    case DaemonState::count:
      break;
  }
  return up();
}

bool allowed(DaemonState state, Action action) {
  return permit(example(state), action).has_value();
}

TEST(StateMachine, EveryStateHasANameOfItsOwnAndCanBeReached) {
  std::set<std::string_view> names;
  for (std::size_t s = 0; s < kStateCount; ++s) {
    EXPECT_TRUE(names.insert(state_name(DaemonState(s))).second);
    EXPECT_EQ(state_of(example(DaemonState(s))), DaemonState(s)) << state_name(DaemonState(s));
  }
  EXPECT_EQ(names.count(""), 0U);
}

TEST(StateMachine, EveryStateTakesEveryEventAsOneTableSays) {
  using S = DaemonState;
  // Rows as DaemonState, columns as kEvents.
  constexpr S kNext[kStateCount][kEventCount] = {
      {S::stopping, S::stopping, S::stopping, S::stopping, S::stopping, S::stopping, S::stopping,
       S::stopping, S::stopping, S::stopping, S::stopping, S::stopping},
      {S::waiting_for_camera, S::starting, S::starting, S::starting, S::starting, S::starting,
       S::starting, S::starting, S::starting, S::starting, S::starting, S::stopping},
      {S::fault, S::fault, S::fault, S::fault, S::fault, S::fault, S::fault, S::fault, S::fault,
       S::fault, S::waiting_for_display, S::stopping},
      {S::waiting_for_camera, S::running, S::waiting_for_camera, S::waiting_for_camera,
       S::waiting_for_camera, S::waiting_for_camera, S::waiting_for_camera, S::waiting_for_camera,
       S::waiting_for_camera, S::fault, S::waiting_for_camera, S::stopping},
      {S::waiting_for_display, S::waiting_for_display, S::waiting_for_camera, S::running,
       S::waiting_for_display, S::waiting_for_display, S::waiting_for_display,
       S::waiting_for_display, S::waiting_for_display, S::fault, S::waiting_for_display,
       S::stopping},
      {S::job_running, S::job_running, S::waiting_for_camera, S::job_running,
       S::waiting_for_display, S::job_running, S::running, S::job_running, S::job_running, S::fault,
       S::job_running, S::stopping},
      {S::running, S::running, S::waiting_for_camera, S::running, S::waiting_for_display,
       S::job_running, S::running, S::running, S::running, S::fault, S::running, S::stopping},
  };
  for (std::size_t s = 0; s < kStateCount; ++s) {
    for (std::size_t e = 0; e < kEventCount; ++e) {
      EXPECT_EQ(state_of(after(example(S(s)), kEvents[e])), kNext[s][e])
          << state_name(S(s)) << " with event " << e;
    }
  }
}

TEST(StateMachine, AnEventChangesOneConditionAndRepeatingItChangesNothing) {
  for (const Conditions& conditions : all_conditions()) {
    for (std::size_t e = 0; e < kEventCount; ++e) {
      const Conditions once = after(conditions, kEvents[e]);
      const int changed =
          (once.started != conditions.started) + (once.camera != conditions.camera) +
          (once.display != conditions.display) + (once.job != conditions.job) +
          (once.measuring != conditions.measuring) + (once.loop != conditions.loop) +
          (once.fixed != conditions.fixed) + (once.reload != conditions.reload) +
          (once.lattice != conditions.lattice) + (once.fault != conditions.fault) +
          (once.stopping != conditions.stopping);
      EXPECT_LE(changed, 1);
      EXPECT_EQ(after(once, kEvents[e]), once);
    }
  }
}

TEST(StateMachine, WithBothMissingItWaitsForTheCameraFirst) {
  const Conditions neither = by({kStarted});
  EXPECT_EQ(state_of(neither), DaemonState::waiting_for_camera);
  const Conditions camera_only = after(neither, kCameraConnected);
  EXPECT_EQ(state_of(camera_only), DaemonState::waiting_for_display);
  EXPECT_EQ(state_of(after(camera_only, kDisplayConnected)), DaemonState::running);
}

TEST(StateMachine, StoppingIsFinal) {
  for (Conditions conditions : all_conditions()) {
    conditions.stopping = true;
    for (std::size_t e = 0; e < kEventCount; ++e) {
      EXPECT_EQ(state_of(after(conditions, kEvents[e])), DaemonState::stopping);
    }
  }
}

TEST(StateMachine, EveryStatePermitsEveryActionAsOneTableSays) {
  // Rows as DaemonState, columns as Action: read, set_camera, set_sensor, set_aberration,
  // show_pattern, start_job, clear_reference, cancel_job, save_config, set_refine, close_loop,
  // open_loop, set_correction, reload_config, record, watch,
  // present, grab, set_corrector, start_hologram_job.
  constexpr bool kAllowed[kStateCount][kActionCount] = {
      {true,  false, false, false, false, false, false, false, false, false,
       false, false, false, false, false, false, false, false, false, false},  // stopping
      {true,  false, false, false, false, false, false, false, false, false,
       false, false, false, false, false, false, false, false, false, false},  // starting
      {true,  true, false, false, false, false, true, true, true, true,
       false, true, false, true,  true,  false, true, true, true, false},  // fault
      {true,  true, true, true, true, false, true, true,  true, true,
       false, true, true, true, true, false, true, false, true, false},  // waiting_for_camera
      {true,  true, false, false, false, false, true, true, true, true,
       false, true, false, true,  true,  false, true, true, true, false},  // waiting_for_display
      {true,  false, false, false, false, false, false, true, false, true,
       false, true,  false, false, true,  false, true,  true, true,  false},  // job_running
      {true, true, true, true, true, true, true, true, true, true,
       true, true, true, true, true, true, true, true, true, true},  // running
  };
  for (std::size_t s = 0; s < kStateCount; ++s) {
    for (std::size_t a = 0; a < kActionCount; ++a) {
      EXPECT_EQ(allowed(DaemonState(s), Action(a)), kAllowed[s][a])
          << state_name(DaemonState(s)) << " with action " << a;
    }
  }
}

TEST(StateMachine, ARefusalNamesTheObstacleAndTheWayOut) {
  for (const Conditions& conditions : all_conditions()) {
    for (std::size_t a = 0; a < kActionCount; ++a) {
      const Result<void> answer = permit(conditions, Action(a));
      if (answer) continue;
      EXPECT_EQ(answer.error().reason, obstacle(conditions, Action(a))->reason);
      EXPECT_EQ(answer.error().reason.find("running:"), std::string::npos);
      EXPECT_NE(answer.error().reason.find("; "), std::string::npos) << answer.error().reason;
      EXPECT_TRUE(answer.error().code == Errc::refused || answer.error().code == Errc::unavailable);
    }
  }
}

TEST(StateMachine, AFixedArrayShowsNoHologramAndMeasures) {
  Conditions conditions = up();
  conditions.fixed = true;
  EXPECT_EQ(state_of(conditions), DaemonState::running);
  for (const Action action :
       {Action::set_aberration, Action::show_pattern, Action::close_loop, Action::set_correction,
        Action::present, Action::start_hologram_job}) {
    EXPECT_FALSE(permit(conditions, action));
  }
  for (const Action action : {Action::start_job, Action::set_sensor, Action::clear_reference,
                              Action::record, Action::grab, Action::set_camera}) {
    EXPECT_TRUE(permit(conditions, action));
  }
}

TEST(StateMachine, WhatAReloadOrASwitchOfLatticesRestoresIsNotChangedMeanwhile) {
  const std::array changing{Event{&Conditions::reload, true}, Event{&Conditions::lattice, true}};
  for (const Event& begun : changing) {
    const Conditions conditions = after(up(), begun);
    EXPECT_EQ(state_of(conditions), DaemonState::running);
    for (const Action action :
         {Action::set_camera, Action::set_sensor, Action::set_aberration, Action::show_pattern,
          Action::start_job, Action::start_hologram_job, Action::clear_reference,
          Action::save_config, Action::close_loop, Action::set_correction, Action::reload_config,
          Action::present, Action::watch}) {
      const Result<void> answer = permit(conditions, action);
      ASSERT_FALSE(answer);
      EXPECT_EQ(answer.error().code, Errc::refused);
      EXPECT_NE(answer.error().reason.find("in a moment"), std::string::npos);
    }
    for (const Action action : {Action::read, Action::cancel_job, Action::open_loop, Action::record,
                                Action::grab, Action::set_corrector}) {
      EXPECT_TRUE(permit(conditions, action));
    }
  }
  EXPECT_FALSE(permit(after(up(), changing[0]), Action::set_refine));
  EXPECT_TRUE(permit(after(up(), changing[1]), Action::set_refine)) << "no part of a lattice";
}

TEST(StateMachine, AMissingDeviceIsUnavailableAndSaidSo) {
  const Result<void> camera = permit(example(DaemonState::waiting_for_camera), Action::start_job);
  EXPECT_EQ(camera.error().code, Errc::unavailable);
  EXPECT_NE(camera.error().reason.find("no camera is in use"), std::string::npos);
  const Result<void> display =
      permit(example(DaemonState::waiting_for_display), Action::set_aberration);
  EXPECT_EQ(display.error().code, Errc::unavailable);
  EXPECT_NE(display.error().reason.find("display"), std::string::npos);
}

TEST(StateMachine, WithBothMissingTheReasonIsTheDeviceThatTheActionNeeds) {
  const Conditions neither = by({kStarted});
  const Result<void> answer = permit(neither, Action::set_aberration);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().reason.find("the SLM's display is not in use"), std::string::npos);
}

TEST(StateMachine, ASensorIsNotChangedUnderARunningJob) {
  const Result<void> answer = permit(example(DaemonState::job_running), Action::set_sensor);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, Errc::refused);
  EXPECT_NE(answer.error().reason.find("job.cancel"), std::string::npos);
}

TEST(StateMachine, AJobThatShowsPicturesLeavesTheCameraToClients) {
  const Conditions showing = after(up(), kJobBegun);
  EXPECT_EQ(state_of(showing), DaemonState::job_running);
  EXPECT_TRUE(permit(showing, Action::set_camera));
  EXPECT_FALSE(permit(showing, Action::set_sensor));
  EXPECT_FALSE(permit(showing, Action::save_config));
}

TEST(StateMachine, WhatAClosedLoopSteersByIsNotChanged) {
  const Conditions closed = after(up(), kLoopClosed);
  EXPECT_EQ(state_of(closed), DaemonState::running);
  for (const Action action :
       {Action::set_sensor, Action::show_pattern, Action::start_job, Action::clear_reference,
        Action::close_loop, Action::set_correction}) {
    const Result<void> answer = permit(closed, action);
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().reason.find("loop.open"), std::string::npos);
  }
  EXPECT_TRUE(permit(closed, Action::set_aberration));
  EXPECT_TRUE(permit(closed, Action::set_camera));
  EXPECT_TRUE(permit(closed, Action::open_loop));
}

static_assert(state_of(Conditions{}) == DaemonState::starting);
static_assert(obstacle(Conditions{}, Action::read) == nullptr);

}  // namespace
}  // namespace ovws
