/// The commissioning without a daemon: names, refusals and its document.
#include "daemon/examine/commission/commissioning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <set>
#include <thread>

#include "daemon/examine/commission/bench.hpp"
#include "daemon/examine/commission/step.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;

/// An endpoint where nothing answers.
Settings nowhere() {
  Settings settings;
  settings.daemon.endpoint = "tcp://127.0.0.1:9";
  settings.daemon.timeout_s = 0.05;
  return settings;
}

Report ended(const Commissioning& commissioning) {
  for (int k = 0; k < 1000 && commissioning.report().running; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const Report report = commissioning.report();
  EXPECT_FALSE(report.running.has_value());
  return report;
}

TEST(WatchedFrames, AnEarlierSpanIsNotPartOfTheMedianOfTheNewestOne) {
  std::vector<WatchedFrame> frames;
  for (int k = 0; k < 100; ++k) frames.push_back({1, 0.1 * k, k < 90 ? 0.1 : 0.001 * k});
  frames[95].rms_waves = std::nullopt;
  EXPECT_EQ(newest(frames, 0.45).size(), 5U);
  EXPECT_EQ(median_rms_waves(newest(frames, 0.45)), 0.001 * 98);
  EXPECT_EQ(median_rms_waves(newest(frames, 0.25)), 0.001 * 98);
  EXPECT_EQ(median_rms_waves(frames), 0.1);
  EXPECT_EQ(newest(frames, 0.0).size(), 1U);
  EXPECT_EQ(newest(frames, 100.0).size(), 100U);
  EXPECT_EQ(median_rms_waves(newest({}, 1.0)), std::nullopt);
}

TEST(Commissioning, TheDocumentHasItsKeys) {
  const Commissioning commissioning(nowhere());
  const json document = to_json(ended(commissioning));
  EXPECT_EQ(document.at("schema"), "ovws.commission/1");
  EXPECT_TRUE(document.at("running").is_null());
  ASSERT_EQ(document.at("steps").size(), step_names().size());
  std::set<std::string> names;
  for (const json& step : document.at("steps")) {
    ASSERT_EQ(step.size(), 8U);
    names.insert(step.at("name").get<std::string>());
    EXPECT_EQ(step.at("state"), "open") << "nothing is known of a daemon that does not answer";
    EXPECT_TRUE(step.at("verdict").is_null());
    EXPECT_TRUE(step.at("offers").empty());
    EXPECT_EQ(step.at("can_undo"), false);
    EXPECT_TRUE(step.at("picture").is_null());
    EXPECT_FALSE(step.at("purpose").get<std::string>().empty());
  }
  EXPECT_EQ(names.size(), step_names().size());
}

TEST(Commissioning, AStepWithoutADaemonFailsAndSaysSo) {
  Commissioning commissioning(nowhere());
  ended(commissioning);
  ASSERT_TRUE(commissioning.act("run", "camera"));
  const json step = to_json(ended(commissioning)).at("steps").at(1);
  EXPECT_EQ(step.at("state"), "failed");
  EXPECT_EQ(step.at("verdict").at("wellness"), "bad");
  EXPECT_NE(step.at("verdict").at("text").get<std::string>().find("does not answer"),
            std::string::npos);
}

TEST(Commissioning, OnlyTheSkippedStepIsNoLongerOpen) {
  Commissioning commissioning(nowhere());
  EXPECT_EQ(ended(commissioning).steps.at(0).state, State::open);
  ASSERT_TRUE(commissioning.act("skip", "doctor"));
  const Report after = ended(commissioning);
  EXPECT_EQ(after.steps.at(0).state, State::skipped);
  EXPECT_STREQ(after.steps.at(1).name, "camera");
  EXPECT_EQ(after.steps.at(1).state, State::open);
}

TEST(Commissioning, AModulatorLeavesOutWhatItCannotDo) {
  const auto left_out = [](const char* modulator) {
    const Look look{{"config.get", {{"modulator", modulator}}}};
    std::set<std::string> names;
    for (const Step& step : steps()) {
      if (!needless(step, look).empty()) names.insert(step.name);
    }
    return names;
  };
  EXPECT_TRUE(left_out("slm").empty());
  EXPECT_EQ(left_out("dmd"), std::set<std::string>{"lut"});
  EXPECT_EQ(left_out("fixed"),
            (std::set<std::string>{"output", "spot", "lut", "settle", "clear", "flatness",
                                   "brightness", "calibration", "loop"}));
  EXPECT_TRUE(needless(steps()[2], {}).empty()) << "nothing is known of a daemon without an answer";
}

TEST(Commissioning, RefusesWhatItDoesNotKnow) {
  Commissioning commissioning(nowhere());
  ended(commissioning);
  const auto run = commissioning.act("run", "camara", "");
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::invalid);
  EXPECT_EQ(run.error().field, "step");
  EXPECT_NE(run.error().reason.find("camera"), std::string::npos);
  EXPECT_EQ(commissioning.act("rum", "camera", "").error().field, "action");
  EXPECT_EQ(commissioning.act("offer", "camera", "x").error().field, "offer");
  EXPECT_EQ(commissioning.act("undo", "camera", "").error().code, Errc::refused);
  EXPECT_FALSE(commissioning.picture_png("camera"));
  EXPECT_TRUE(commissioning.act("cancel", "", "")) << "nothing runs";
}

TEST(Commissioning, AReferenceFromTheModelIsNotDone) {
  const auto has = [](const json& taken, const json& source) {
    return has_measured_reference({{"reference.get", {{"taken", taken}, {"source", source}}}});
  };
  EXPECT_TRUE(has(true, "measured"));
  EXPECT_FALSE(has(true, "model"));
  EXPECT_FALSE(has(false, nullptr));
}

TEST(Commissioning, WhatLaterStepsNeedIsDone) {
  const auto done = [](const char* name, const Look& look) {
    return std::ranges::find(steps(), std::string_view(name), &Step::name)->is_done(look);
  };
  Look look{{"system.status", {{"camera", {{"connected", true}}}, {"slm", {{"connected", true}}}}},
            {"lut.get", {{"measured", false}}},
            {"registration.get", {{"registered", false}}},
            {"calibration.get", {{"in_force", false}}},
            {"loop.get", {{"closed", false}}}};
  const auto names = {"doctor", "camera", "output", "settle", "loop", "save"};
  for (const char* name : names) EXPECT_EQ(done(name, look), std::nullopt) << name;
  look["registration.get"]["registered"] = true;
  for (const char* name : {"doctor", "camera", "output"}) EXPECT_EQ(done(name, look), true) << name;
  for (const char* name : {"settle", "loop", "save"}) EXPECT_EQ(done(name, look), std::nullopt);
  look["calibration.get"]["in_force"] = true;
  EXPECT_EQ(done("settle", look), true);
  look["system.status"]["camera"]["connected"] = false;
  EXPECT_EQ(done("camera", look), false);
}

TEST(Commissioning, OneActionAtATime) {
  std::promise<void> may_end;
  Settings settings = nowhere();
  settings.examine = [end = may_end.get_future().share()] {
    end.wait_for(std::chrono::minutes(1));
    return examine::Findings{};
  };
  Commissioning commissioning(settings);
  ended(commissioning);
  ASSERT_TRUE(commissioning.act("run", "doctor"));
  ASSERT_TRUE(commissioning.report().running.has_value());
  EXPECT_EQ(commissioning.report().running->step, "doctor");
  const auto second = commissioning.act("run", "camera");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::refused);
  may_end.set_value();
  ended(commissioning);
}

}  // namespace
}  // namespace ovws::commission
