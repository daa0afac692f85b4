/// Borrowing a bench and waiting for jobs, with a daemon of canned replies.
#include "daemon/shared/borrow.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <mutex>
#include <thread>

#include "drivers/zmq/control_server.hpp"
#include "proto/json_text.hpp"
#include "tests/contract/zmq/endpoints.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

/// Answers by method, and keeps the methods that change something.
class FakeDaemon {
 public:
  std::map<std::string, json> results;  ///< before the first call only
  std::vector<std::string> changes;     ///< after the last call only
  std::string refused;                  ///< a method that is refused

  FakeDaemon() {
    common.endpoint = test::ipc_endpoint("borrow");
    common.timeout_s = 60.0;
    auto bound =
        ControlServer::bind(common.endpoint, {1 << 20, 0, "", ""},
                            [this](const ControlRequest& request, const SendReply& reply) {
                              reply(json_text(answer(json::parse(request.bytes))), nullptr);
                            });
    EXPECT_TRUE(bound);
    server_ = std::move(*bound);
    thread_ = std::thread([this] {
      while (!stop_) server_->do_work();
    });
  }
  ~FakeDaemon() {
    stop_ = true;
    thread_.join();
  }

  Common common;

 private:
  json answer(const json& request) {
    const auto method = request.at("method").get<std::string>();
    const json id = request.at("id");
    if (method == refused) return {{"id", id}, {"error", {{"message", "not now"}}}};
    const auto found = results.find(method);
    if (found != results.end()) return {{"id", id}, {"result", found->second}};
    changes.push_back(method + " " + request.at("params").dump());
    return {{"id", id}, {"result", json::object()}};
  }

  std::unique_ptr<ControlServer> server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

json modes(double waves) {
  return {{"modes", {{{"j", 4}, {"name", "defocus"}, {"waves", waves}}}},
          {"patterns", json::array()}};
}

json closed_loop(double gain) {
  json loop{{"closed", true}, {"paused", false}, {"gain", gain}};
  for (const char* key :
       {"law", "leak", "modes", "gains", "offsets", "limit_waves", "patience_s"}) {
    loop[key] = nullptr;
  }
  return loop;
}

const Parts kBefore{
    {Part::aberration, {{"modes", {{{"j", 4}, {"waves", 0.5}}}}}},
    {Part::correction, {{"modes", json::array()}}},
    {Part::loop, {{"closed", true}, {"paused", true}, {"params", {{"gain", 0.3}}}}}};

TEST(Borrow, ReadsPartsAsTheParamsThatRestoreThem) {
  FakeDaemon daemon;
  daemon.results = {{"aberration.get", modes(0.5)}, {"loop.get", closed_loop(0.3)}};
  daemon.results["loop.get"]["paused"] = true;
  const auto parts = parts_of(daemon.common, {Part::aberration, Part::loop});
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->at(Part::aberration), kBefore.at(Part::aberration));
  EXPECT_EQ(parts->at(Part::loop), kBefore.at(Part::loop));
}

TEST(Borrow, DoesNotReadASequenceOfPatterns) {
  FakeDaemon daemon;
  daemon.results["aberration.get"] = modes(0.5);
  daemon.results["aberration.get"]["patterns"] = {1, 2};
  EXPECT_FALSE(parts_of(daemon.common, {Part::aberration}));
}

TEST(Borrow, RestoresOnlyWhatHasChangedWithTheLoopOpen) {
  FakeDaemon daemon;
  daemon.results = {{"aberration.get", modes(0.1)},
                    {"correction.get", {{"modes", json::array()}}},
                    {"loop.get", closed_loop(0.9)}};
  EXPECT_TRUE(Borrow(daemon.common, kBefore).restore());
  EXPECT_EQ(daemon.changes,
            (std::vector<std::string>{"loop.open {\"keep\":true}",
                                      R"(aberration.set {"modes":[{"j":4,"waves":0.5}]})",
                                      R"(correction.set {"modes":[]})",  // it may have stepped
                                      "loop.close {\"gain\":0.3}", "loop.pause {}"}));
}

TEST(Borrow, TheCorrectionOfALoopThatStaysClosedIsTheLoops) {
  FakeDaemon daemon;
  daemon.results = {{"aberration.get", modes(0.5)},
                    {"correction.get", modes(0.2)},
                    {"loop.get", closed_loop(0.3)}};
  daemon.results["loop.get"]["paused"] = true;
  { const Borrow unchanged(daemon.common, kBefore); }
  EXPECT_TRUE(daemon.changes.empty());
}

TEST(Borrow, AnErrorIsSaidWithWhatIsNotRestored) {
  FakeDaemon daemon;
  daemon.results = {{"correction.get", modes(0.2)}};
  daemon.refused = "correction.set";
  Borrow borrowed(daemon.common, {{Part::correction, {{"modes", json::array()}}}});
  const auto done = borrowed.restore_after(attempt([] { stop("the camera is gone"); }));
  ASSERT_FALSE(done);
  const std::string message = message_of(done.error());
  EXPECT_NE(message.find("the camera is gone; not everything could be restored"), std::string::npos)
      << message;
  EXPECT_NE(message.find("ovws call correction.set"), std::string::npos) << message;
}

TEST(Borrow, WhatIsKeptIsNotRestored) {
  FakeDaemon daemon;
  Borrow(daemon.common, kBefore).keep();
  EXPECT_TRUE(daemon.changes.empty());
}

TEST(Job, ReturnsItsResultAndCancelsOnce) {
  FakeDaemon daemon;
  daemon.results = {{"lut.run", {{"job", 7}}},
                    {"job.get", {{"state", "done"}, {"progress", 1.0}, {"result", 5}}}};
  int shown = 0;
  const JobWait wait{[] { return true; }, [&](const json&) { ++shown; }};
  EXPECT_EQ(call_and_wait(daemon.common, "lut.run", json::object(), wait), json(5));
  EXPECT_EQ(shown, 1);
  EXPECT_EQ(daemon.changes, std::vector<std::string>{"job.cancel {\"job\":7}"});
}

TEST(Job, SaysWhyItHasFailed) {
  FakeDaemon daemon;
  daemon.results["job.get"] = {{"state", "cancelled"}, {"progress", 0.5}, {"error", nullptr}};
  const auto cancelled = end_of_job(daemon.common, 7, {});
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(message_of(cancelled.error()), "the job was cancelled");
  daemon.results["job.get"]["error"] = {{"message", "no light"}};
  EXPECT_EQ(message_of(end_of_job(daemon.common, 7, {}).error()), "no light");
}

}  // namespace
}  // namespace ovws::cli
