/// Leases: who may change what, against an independent table, and the daemon's state.
#include "daemon/ovwsd/lease/leases.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/ovwsd/actor/stream_queue.hpp"

namespace ovws {
namespace {

constexpr std::size_t kRequestCount = std::size_t(Request::count);

class LeasesTest : public testing::Test {
 protected:
  explicit LeasesTest(bool fixed = false) : leases_(events_, fixed) {
    leases_.set(&Conditions::started, true);
    set_camera(true, "");
    set_slm(true, "");
    leases_.on_turn([this](Holder holder, const std::function<void()>& then) {
      turns_.push_back(holder);
      if (then) posted_.push_back(then);
    });
  }
  void set_camera(bool connected, const std::string& cause) {
    leases_.set_device("camera", &Conditions::camera, connected, cause);
  }
  void set_slm(bool connected, const std::string& cause) {
    leases_.set_device("slm", &Conditions::display, connected, cause);
  }
  LeasePtr taken(Request request) {
    auto lease = leases_.take(request);
    EXPECT_TRUE(lease) << lease.error().reason;
    return lease ? std::move(*lease) : nullptr;
  }
  LeasePtr begun(Request request) {
    auto lease = taken(request);
    lease->begin([] {});
    return lease;
  }
  std::string refusal(Request request) {
    const auto lease = leases_.take(request);
    return lease ? "" : lease.error().reason;
  }
  /// An `x` for each request that is permitted now, in the order of Request.
  std::string permitted() {
    std::string all;
    for (std::size_t k = 0; k < kRequestCount; ++k) {
      all += leases_.take(Request(k)) ? "x" : ".";
    }
    return all;
  }
  /// Does what the owner of the sensor was asked to do.
  void work() {
    for (const auto& then : std::exchange(posted_, {})) then();
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
  Leases leases_;
  std::vector<Holder> turns_;
  std::vector<std::function<void()>> posted_;
};

class FixedArrayTest : public LeasesTest {
 protected:
  FixedArrayTest() : LeasesTest(true) {}
};

// Columns: read, act, grab, set_camera, set_devices, set_sensor, set_measured, set_aberration,
// set_correction, show_pattern, set_refinement, save_settings, run_job, run_hologram_job, present,
// watch, close_loop, use_lattice, reload.
constexpr std::string_view kFree = "xxxxxxxxxxxxxxxxxxx";

TEST_F(LeasesTest, EachDeviceThatIsMissingIsMissedByWhatNeedsIt) {
  EXPECT_EQ(permitted(), kFree);
  set_camera(false, "");
  EXPECT_EQ(permitted(), "xx.xxxxxxxxx..x..xx");
  set_slm(false, "");
  EXPECT_EQ(permitted(), "xx.xx.x...xx..x...x");
  set_camera(true, "");
  EXPECT_EQ(permitted(), "xxxxx.x...xx..x...x");
}

TEST_F(LeasesTest, WhatAHolderDependsOnIsNotChangedMeanwhile) {
  struct Row {
    Request holder;
    std::string_view permitted;
  };
  constexpr std::array kRows{
      Row{Request::run_job, "xxx.......x........"},
      Row{Request::run_hologram_job, "xxx.......x........"},
      Row{Request::present, "xxxx......x........"},
      Row{Request::watch, "xxxxxxxxxxxx....xxx"},
      Row{Request::close_loop, "xxxx...x..xx...x..."},
      Row{Request::use_lattice, "xxx.......x....x..."},
      Row{Request::reload, "xxx............x..."},
  };
  for (const Row& row : kRows) {
    SCOPED_TRACE(int(row.holder));
    auto lease = taken(row.holder);
    EXPECT_EQ(permitted(), row.permitted) << "from the moment that it is taken";
    lease->begin([] {});
    EXPECT_EQ(permitted(), row.permitted);
    lease->end();
    EXPECT_EQ(permitted(), kFree);
  }
}

TEST_F(LeasesTest, ClientsChangesDoNotExcludeEachOther) {
  const auto first = taken(Request::set_sensor);
  EXPECT_TRUE(leases_.take(Request::set_sensor));
  EXPECT_EQ(permitted(), kFree);
}

TEST_F(FixedArrayTest, ShowsNoHologramAndMeasures) {
  EXPECT_EQ(permitted(), "xxxxxxx...xxx..x..x");
  EXPECT_NE(refusal(Request::close_loop).find("corrector.set"), std::string::npos);
}

TEST_F(LeasesTest, ADaemonThatStopsOrStartsOnlyAnswersQuestions) {
  leases_.set(&Conditions::stopping, true);
  EXPECT_EQ(permitted(), "x..................");
  EXPECT_NE(refusal(Request::act).find("is stopping;"), std::string::npos);
  leases_.set(&Conditions::stopping, false);
  leases_.set(&Conditions::started, false);
  EXPECT_EQ(permitted(), "x..................");
  EXPECT_NE(refusal(Request::act).find("is still starting;"), std::string::npos);
}

TEST_F(LeasesTest, ARefusalNamesTheHolderAndTheWayOut) {
  const std::pair<Request, const char*> holders[]{{Request::run_job, "job.cancel"},
                                                  {Request::close_loop, "loop.open"},
                                                  {Request::reload, "is being reloaded; repeat"},
                                                  {Request::use_lattice, "lattice is being taken"}};
  for (const auto& [holder, text] : holders) {
    const auto lease = taken(holder);
    const auto refused = leases_.take(Request::set_sensor);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::refused);
    EXPECT_NE(refused.error().reason.find(text), std::string::npos) << refused.error().reason;
  }
  set_camera(false, "");
  const auto refused = leases_.take(Request::grab);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::unavailable);
  EXPECT_NE(refused.error().reason.find("no camera is in use"), std::string::npos);
  set_slm(false, "");
  EXPECT_NE(refusal(Request::set_aberration).find("the SLM's display"), std::string::npos)
      << "the device that the request needs";
}

TEST_F(LeasesTest, AHolderBeginsWhenTheChangesThatWerePermittedBeforeHaveEnded) {
  auto first = taken(Request::set_sensor);
  auto second = taken(Request::set_camera);
  const auto other = taken(Request::set_refinement);
  bool runs = false;
  const auto job = taken(Request::run_job);
  job->begin([&] { runs = true; });
  first.reset();
  EXPECT_TRUE(posted_.empty());
  EXPECT_NE(refusal(Request::set_sensor), "") << "nothing new comes before it";
  second->end();
  ASSERT_EQ(posted_.size(), 1U);
  EXPECT_FALSE(runs) << "in the thread of the sensor's owner";
  work();
  EXPECT_TRUE(runs);
  EXPECT_EQ(turns_, std::vector{Holder::job});
}

TEST_F(LeasesTest, TheSensorTurnsFromOneHolderToTheNext) {
  begun(Request::run_job);
  begun(Request::close_loop)->end();
  const auto watch = begun(Request::watch);
  EXPECT_EQ(turns_, (std::vector{Holder::job, Holder::nobody, Holder::loop, Holder::nobody,
                                 Holder::nobody}))
      << "who watches does not have it";
}

TEST_F(LeasesTest, ALeaseThatEndsBeforeItBeginsIsNoTurn) {
  taken(Request::run_job)->end();
  auto change = taken(Request::set_sensor);
  auto waits = taken(Request::run_job);
  bool runs = false;
  // As a job does, what waits keeps its own lease.
  waits->begin([&runs, waits] { runs = true; });
  waits->end();
  change.reset();
  work();
  EXPECT_FALSE(runs);
  EXPECT_TRUE(turns_.empty());
  EXPECT_EQ(permitted(), kFree);
}

TEST_F(LeasesTest, WhatTheOwnerOfTheSensorDropsEndsItsLease) {
  leases_.on_turn([](Holder, const std::function<void()>&) {});
  auto change = taken(Request::set_sensor);
  auto waits = taken(Request::run_job);
  Lease& job = *waits;
  job.begin([waits = std::move(waits)] {});
  EXPECT_NE(permitted(), kFree);
  change.reset();
  EXPECT_EQ(permitted(), kFree);
}

TEST_F(LeasesTest, AFaultLastsUntilTheLastOfItsCausesIsGone) {
  set_slm(false, "the mode is wrong");
  set_camera(false, "no such format");
  EXPECT_EQ(leases_.report().state, DaemonState::fault);
  EXPECT_EQ(leases_.report().fault, "camera: no such format; slm: the mode is wrong");
  set_slm(false, "");
  EXPECT_EQ(leases_.report().state, DaemonState::fault);
  set_camera(true, "");
  EXPECT_EQ(leases_.report().state, DaemonState::waiting_for_display);
  EXPECT_EQ(leases_.report().fault, std::nullopt);
}

TEST_F(LeasesTest, EachChangeOfStateIsOneEventAndRepetitionIsNone) {
  (void)reported();
  for (int i = 0; i < 3; ++i) set_slm(false, "the mode is wrong");
  set_slm(false, "");
  set_slm(true, "");
  EXPECT_EQ(reported(), "fault waiting_for_display running ");
  set_camera(false, "no such format");
  set_camera(true, "");
  EXPECT_EQ(reported(), "fault running ");
  begun(Request::present)->end();
  begun(Request::watch)->end();
  begun(Request::close_loop)->end();
  EXPECT_EQ(reported(), "job_running running ") << "who watches does not have the sensor";
  leases_.set(&Conditions::stopping, true);
  set_camera(false, "no such format");
  EXPECT_EQ(reported(), "stopping ");
}

TEST_F(LeasesTest, WithBothMissingItWaitsForTheCameraFirst) {
  set_slm(false, "");
  set_camera(false, "");
  EXPECT_EQ(leases_.report().state, DaemonState::waiting_for_camera);
  EXPECT_FALSE(leases_.has_bench());
  set_camera(true, "");
  EXPECT_EQ(leases_.report().state, DaemonState::waiting_for_display);
  set_slm(true, "");
  EXPECT_TRUE(leases_.has_bench());
  leases_.set(&Conditions::started, false);
  EXPECT_EQ(leases_.report().state, DaemonState::starting);
}

}  // namespace
}  // namespace ovws
