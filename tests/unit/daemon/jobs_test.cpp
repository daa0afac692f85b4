#include "daemon/ovwsd/actor/jobs.hpp"

#include <gtest/gtest.h>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"

namespace ovws {
namespace {

class JobsTest : public testing::Test {
 protected:
  StreamQueue queue_;
  Events events_{queue_};
  Jobs jobs_{events_};
  std::shared_ptr<Jobs::Live> live_;  ///< of the job begun last

  int begin(const std::string& kind = "reference.take") {
    live_ = std::make_shared<Jobs::Live>();
    live_->progress = 0.25;
    return jobs_.begin(kind, live_);
  }

  void fail(const std::string& kind, const std::string& reason) {
    const int id = begin(kind);
    jobs_.finish(id, ovws::fail(Errc::refused, "camera.exposure_us", reason));
    EXPECT_EQ(jobs_.get(id)->state, JobState::failed);
    EXPECT_EQ(jobs_.get(id)->error.value().reason, reason);
  }

  /// The progress reported by each event since the last call.
  std::vector<double> reported() {
    std::vector<double> all;
    while (const auto message = queue_.take()) {
      all.push_back(std::get<EventMessage>(*message).data["progress"].get<double>());
    }
    return all;
  }
};

TEST_F(JobsTest, ARunningJobReportsItsProgress) {
  const auto job = jobs_.get(begin());
  ASSERT_TRUE(job);
  EXPECT_EQ(job->state, JobState::running);
  EXPECT_EQ(job->progress, 0.25);
}

TEST_F(JobsTest, AFinishedJobKeepsItsResult) {
  const int id = begin();
  jobs_.finish(id, nlohmann::json{{"frames", 100}});
  EXPECT_EQ(jobs_.get(id)->state, JobState::done);
  EXPECT_EQ(jobs_.get(id)->progress, 1.0);
  EXPECT_EQ(jobs_.get(id)->result["frames"], 100);
}

TEST_F(JobsTest, AJobWhoseResultIsInUseIsNotCancelled) {
  const int id = begin();
  EXPECT_TRUE(jobs_.use_result(id));
  EXPECT_EQ(jobs_.cancel(id)->state, JobState::running);
  EXPECT_FALSE(live_->stop);
  jobs_.finish(id, nlohmann::json{{"frames", 100}});
  EXPECT_EQ(jobs_.get(id)->state, JobState::done);
  EXPECT_FALSE(jobs_.use_result(id));
}

TEST_F(JobsTest, OnlyARunningJobIsCancelled) {
  const int id = begin();
  EXPECT_FALSE(jobs_.end_cancelled(id));
  EXPECT_EQ(jobs_.cancel(id)->state, JobState::running) << "it has not ended yet";
  EXPECT_TRUE(live_->stop.exchange(false));
  EXPECT_EQ(jobs_.cancel(id)->state, JobState::running);
  EXPECT_FALSE(live_->stop) << "a second request does nothing";
  EXPECT_FALSE(jobs_.runs(id));
  EXPECT_FALSE(jobs_.use_result(id));
  EXPECT_TRUE(jobs_.end_cancelled(id));
  EXPECT_EQ(jobs_.get(id)->state, JobState::cancelled);
  EXPECT_EQ(jobs_.cancel(id)->state, JobState::cancelled);
  jobs_.finish(id, {});
  EXPECT_EQ(jobs_.get(id)->state, JobState::cancelled);
}

TEST_F(JobsTest, AJobThatWasCancelledHasNoResultHoweverItEnds) {
  const int id = begin();
  ASSERT_TRUE(jobs_.cancel(id));
  jobs_.finish(id, ovws::fail(Errc::refused, "", "it was cancelled"));
  EXPECT_EQ(jobs_.get(id)->state, JobState::cancelled);
  EXPECT_FALSE(jobs_.get(id)->error);
  EXPECT_FALSE(jobs_.last_failed());
}

TEST_F(JobsTest, EachQuarterOfAJobIsOneEvent) {
  const int id = begin();
  for (const double progress : {0.0, 0.2, 0.25, 0.4, 0.8, 0.9, 1.0}) {
    live_->progress = progress;
    jobs_.report_progress(id);
  }
  jobs_.finish(id, {});
  jobs_.report_progress(id);
  EXPECT_EQ(reported(), (std::vector<double>{0.0, 0.25, 0.75, 1.0}));
}

TEST_F(JobsTest, TheLastFailureIsKnownAfterLaterJobsOfOtherKinds) {
  EXPECT_FALSE(jobs_.last_failed());
  const std::int64_t before_ns = utc_ns();
  fail("reference.take", "first");
  fail("reference.take", "second");
  for (int i = 0; i < 300; ++i)
    jobs_.finish(begin("lut.run"), {});  // the failed job is no longer remembered
  begin();
  EXPECT_FALSE(jobs_.get(2));
  const auto failed = jobs_.last_failed();
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->job, 2);
  EXPECT_EQ(failed->field, "camera.exposure_us");
  EXPECT_EQ(failed->reason, "second");
  EXPECT_GE(failed->t_failed_ns, before_ns);
  EXPECT_LE(failed->t_failed_ns, utc_ns());
}

TEST_F(JobsTest, AFailureIsForgottenWhenAJobOfItsKindIsDone) {
  fail("lut.run", "no light");
  fail("reference.take", "too bright");
  const int cancelled = begin("reference.take");
  ASSERT_TRUE(jobs_.cancel(cancelled));
  EXPECT_TRUE(jobs_.end_cancelled(cancelled));
  EXPECT_EQ(jobs_.last_failed()->reason, "too bright");
  jobs_.finish(begin("reference.take"), {});
  EXPECT_EQ(jobs_.last_failed()->reason, "no light");
  jobs_.finish(begin("lut.run"), {});
  EXPECT_FALSE(jobs_.last_failed());
}

TEST_F(JobsTest, AnUnknownNumberIsAnError) {
  EXPECT_EQ(jobs_.get(99).error().field, "job");
}

TEST_F(JobsTest, OldJobsAreForgottenButNeverOneThatRuns) {
  const int running = begin();
  const int first = begin();
  jobs_.finish(first, nullptr);
  int last = first;
  for (int i = 0; i < 300; ++i) {
    last = begin();
    jobs_.finish(last, nullptr);
  }
  EXPECT_TRUE(jobs_.runs(running));
  EXPECT_FALSE(jobs_.get(first));
  EXPECT_TRUE(jobs_.get(last));
}

}  // namespace
}  // namespace ovws
