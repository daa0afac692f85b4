/// When a closed loop takes its next step.
#include "daemon/ovwsd/loop/step_due.hpp"

#include <gtest/gtest.h>

#include "tests/support/time.hpp"

namespace ovws {
namespace {

using test::kMs;

/// A display of 100 Hz with a refresh at 1000 ms; a hologram is ready 2 ms after its step, 3 ms to
/// be safe.
StepState state_at(std::int64_t observed_ms) {
  return {.t_observed_ns = observed_ms * kMs,
          .t_refresh_ns = 1000 * kMs,
          .refresh_ns = 10 * kMs,
          .usual_prepare_ns = 2 * kMs,
          .safe_prepare_ns = 3 * kMs};
}

TEST(StepDue, IsJustBeforeTheRefreshThatANewestFrameCanReach) {
  StepState state = state_at(1004);
  state.has_newest = true;
  EXPECT_EQ(t_due_ns(state), 1007 * kMs);
  state.t_observed_ns = 1008 * kMs;  // ready at the refresh, if as fast as usual: at once
  EXPECT_LE(t_due_ns(state), 1008 * kMs);
  state.t_observed_ns = 1009 * kMs;
  EXPECT_EQ(t_due_ns(state), 1017 * kMs);
}

TEST(StepDue, WithAnOlderFrameWaitsUntilANewestOneMustHaveBeenExposed) {
  StepState state = state_at(1001);
  EXPECT_EQ(t_due_ns(state), StepState::kNever) << "the camera's period is not known";
  state.t_exposed_ns = 1009 * kMs;
  EXPECT_EQ(t_due_ns(state), 1007 * kMs);
  state.t_exposed_ns = 1011 * kMs;
  EXPECT_EQ(t_due_ns(state), 1017 * kMs);
}

/// Steps that vary must not present a hologram before the newest one was seen.
TEST(StepDue, IsHalfARefreshBeforeItAtTheEarliest) {
  StepState state = state_at(1001);
  state.t_exposed_ns = 1009 * kMs;
  state.safe_prepare_ns = 60 * kMs;
  EXPECT_EQ(t_due_ns(state), 1005 * kMs);
}

/// With frames of 20 ms, a step that was due later than the next frame would never be taken.
TEST(StepDue, IsBeforeTheNextRefreshHoweverLongAStepTakes) {
  StepState state = state_at(1004);
  state.t_exposed_ns = 1003 * kMs;
  for (int usual_ms = 0; usual_ms < 100; ++usual_ms) {
    state.usual_prepare_ns = usual_ms * kMs;
    EXPECT_LT(t_due_ns(state), 1014 * kMs) << usual_ms << " ms";
  }
}

TEST(StepDue, IsAtOnceIfRefreshesAreNotKnown) {
  StepState state = state_at(1004);
  state.t_refresh_ns = 0;
  state.t_exposed_ns = 1011 * kMs;
  EXPECT_EQ(t_due_ns(state), 1011 * kMs);
  state.has_newest = true;
  EXPECT_EQ(t_due_ns(state), 1004 * kMs);
}

}  // namespace
}  // namespace ovws
