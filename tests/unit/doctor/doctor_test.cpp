#include "daemon/examine/machine/doctor.hpp"

#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {

static Findings answers(const DaemonFacts& facts) {
  return answers(facts, kDoctor);
}

namespace {

const nlohmann::json kWaits{{"state", "waiting_for_camera"}};

DaemonFacts running() {
  DaemonFacts facts;
  facts.endpoint = "tcp://127.0.0.1:7702";
  facts.own_version = "1.2.3";
  facts.status = nlohmann::json{
      {"state", "running"},
      {"versions", {{"ovws", "1.2.3"}}},
      {"camera",
       {{"connected", true},
        {"info", {{"model", "M1"}}},
        {"fault", nullptr},
        {"brightest", 0.7},
        {"settings", {{"frame_rate_hz", 100.0}, {"exposure_us", 2000.0}}}}},
      {"rates", {{"grabbed_hz", 99.3}, {"expected_hz", 100.0}}},
      {"slm",
       {{"connected", true}, {"fault", nullptr}, {"info", {{"width", 100}, {"height", 50}}}}},
      {"store", {{"directory", "/var/lib/ovws"}, {"reason", nullptr}}},
      {"failed_job", nullptr},
  };
  facts.wavefront = {{"saturated", 0.0}, {"subapertures", 19}};
  facts.levels = nlohmann::json{{"equal", true}, {"differing_pixels", 0}};
  return facts;
}

TEST(DoctorDaemon, AHealthyDaemonHasNoFinding) {
  for (const Finding& one : answers(running(), kDoctor))
    EXPECT_EQ(one.severity, Severity::good) << one.text;
  EXPECT_EQ(camera_of(running()), DaemonsCamera::with);
}

TEST(DoctorDaemon, OneThatHasJustStartedIsAskedUntilItsDevicesAreOpen) {
  int asked = 0;
  const auto ask = [&](double opened_after_s, const nlohmann::json& before = kWaits) {
    asked = 0;
    return ask_opened(
        [&](const std::string&) {
          const double uptime_s = 3.0 + ++asked;
          DaemonFacts facts = running();
          (*facts.status)["uptime_s"] = uptime_s;
          if (uptime_s < opened_after_s) facts.status->merge_patch(before);
          return facts;
        },
        "tcp://127.0.0.1:7702", std::chrono::milliseconds(0));
  };
  EXPECT_EQ(ask(0.0).status->at("state"), "running");
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(ask(4.5).status->at("state"), "running");
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(ask(60.0).status->at("state"), "waiting_for_camera");
  EXPECT_EQ(asked, 2) << "it has no camera";
  EXPECT_EQ(ask(4.5, {{"state", "fault"}, {"camera", nullptr}}).status->at("state"), "running");
  EXPECT_EQ(asked, 2) << "the output is at fault, the camera may be opening";
  EXPECT_EQ(ask(4.5, {{"state", "fault"}}).status->at("state"), "fault");
  EXPECT_EQ(asked, 1) << "it has a camera";
  EXPECT_EQ(ask(4.5, {{"state", "starting"}, {"uptime_s", "x"}}).status->at("state"), "starting");
  EXPECT_EQ(asked, 1) << "an uptime that is no number";
}

TEST(DoctorDaemon, OneThatStartsAgainAndAgainIsNotAskedForEver) {
  int asked = 0;
  const auto just_started = [&](const std::string&) {
    ++asked;
    DaemonFacts facts = running();
    facts.status->merge_patch(kWaits);
    (*facts.status)["uptime_s"] = 0.5;
    return facts;
  };
  const auto pause = std::chrono::milliseconds(0);
  EXPECT_EQ(ask_opened(just_started, "tcp://127.0.0.1:7702", pause).status->at("uptime_s"), 0.5);
  EXPECT_EQ(asked, 12);
}

TEST(DoctorDaemon, ADaemonThatDoesNotAnswerIsNoFault) {
  DaemonFacts facts;
  facts.why = "no reply within 3 s";
  for (const Finding& one : answers(facts, kDoctor))
    EXPECT_EQ(one.severity, Severity::not_here) << one.name;
  EXPECT_EQ(camera_of(facts), DaemonsCamera::silent);
  facts.asks_for_keys = true;
  expect(facts, "daemon.answer", Severity::not_here, "ovws --key FILE doctor");
  facts.refused = true;
  expect(facts, "daemon.answer", Severity::warning);
}

TEST(DoctorDaemon, FaultsOfTheStatusAreReported) {
  auto facts = running();
  (*facts.status)["versions"]["ovws"] = "1.2.2";
  expect(facts, "daemon.version", Severity::warning, "restart ovwsd");
  (*facts.status)["camera"] = {{"info", nullptr}, {"fault", "no camera answers"}};
  expect(facts, "camera.state", Severity::bad);
  EXPECT_NE(named(answers(facts), "camera.state").text.find("no camera answers"),
            std::string::npos);
  EXPECT_EQ(camera_of(facts), DaemonsCamera::without);
  facts = running();
  (*facts.status)["slm"]["fault"] = "switched off";
  expect(facts, "slm.state", Severity::bad);
  facts = running();
  (*facts.status)["state"] = "waiting_for_camera";
  expect(facts, "daemon.state", Severity::not_here);
  (*facts.status)["camera"]["connected"] = false;
  expect(facts, "camera.state", Severity::bad);
  (*facts.status)["sensor"]["layout_fault"] = "camera.roi: 3 spots fall outside";
  expect(facts, "sensor.layout", Severity::bad, "ovws setup spot");
  EXPECT_TRUE(is_for_later(named(answers(facts), "sensor.layout")));
  (*facts.status)["store"]["reason"] = "the disk is full";
  expect(facts, "daemon.store", Severity::warning);
  (*facts.status)["store"] = {{"directory", nullptr}, {"reason", "/s cannot be created"}};
  EXPECT_NE(named(answers(facts), "daemon.store").text.find("restarts: /s"), std::string::npos);
  (*facts.status)["failed_job"] = {
      {"kind", "lut.run"}, {"reason", "no light"}, {"t_failed", "2026-01-01T00:00:00.000Z"}};
  expect(facts, "daemon.job", Severity::warning, "ovws call --wait lut.run");
  EXPECT_NE(named(answers(facts), "daemon.job").text.find("2026-01-01T00:00:00.000Z"),
            std::string::npos);
}

TEST(DoctorDaemon, ADarkImageIsAWarning) {
  auto facts = running();
  (*facts.status)["camera"]["brightest"] = 0.012;
  expect(facts, "camera.light", Severity::warning, "ovws exposure auto");
  EXPECT_NE(named(answers(facts), "camera.light").text.find("1.2 % of full scale"),
            std::string::npos);
  (*facts.status)["camera"]["brightest"] = nullptr;
  expect(facts, "camera.light", Severity::not_here);
}

TEST(DoctorDaemon, ATooBrightImageIsAWarning) {
  auto facts = running();
  (*facts.status)["camera"]["brightest"] = 1.0;
  facts.wavefront["saturated"] = 1.0 / 19.0;
  expect(facts, "camera.saturation", Severity::note, "ovws exposure auto");
  facts.wavefront["saturated"] = 1.0;
  expect(facts, "camera.saturation", Severity::warning, "ovws exposure auto");
  EXPECT_NE(named(answers(facts), "camera.saturation").text.find("19 of 19 spots are saturated"),
            std::string::npos);
}

TEST(DoctorDaemon, ASlowCameraIsAWarning) {
  auto facts = running();
  (*facts.status)["rates"]["grabbed_hz"] = 71.3;
  expect(facts, "camera.rate", Severity::warning, "ovws rate 71.3");
  EXPECT_NE(named(answers(facts), "camera.rate").text.find("sends 71.3 of 100 frames/s"),
            std::string::npos);
  (*facts.status)["camera"]["settings"]["exposure_us"] = 13000.0;
  expect(facts, "camera.rate", Severity::warning, "ovws exposure 5000us");
  (*facts.status)["camera"]["settings"]["exposure_us"] = 2.0;
  (*facts.status)["rates"] = {{"grabbed_hz", 1234.4}, {"expected_hz", 20000.0}};
  expect(facts, "camera.rate", Severity::warning, "ovws rate 1234");
  EXPECT_NE(named(answers(facts), "camera.rate").text.find("of 20000 frames/s:"),
            std::string::npos);
  (*facts.status)["rates"]["expected_hz"] = nullptr;
  expect(facts, "camera.rate", Severity::not_here);
  (*facts.status)["rates"] = {{"grabbed_hz", 0.0}, {"expected_hz", 100.0}};
  expect(facts, "camera.rate", Severity::not_here);
}

TEST(DoctorDaemon, AnOutputThatShowsOtherLevelsIsAFault) {
  auto facts = running();
  facts.levels->at("differing_pixels") = 50;
  expect(facts, "slm.levels", Severity::warning, "ovws call slm.verify");
  facts.levels->at("differing_pixels") = 4950;
  expect(facts, "slm.levels", Severity::bad, "ovws call slm.verify");
  EXPECT_NE(named(answers(facts), "slm.levels").text.find("stop the compositor"),
            std::string::npos);
  facts.levels.reset();
  facts.why_no_levels = "it cannot be read";
  expect(facts, "slm.levels", Severity::not_here);
}

TEST(DoctorDaemon, TheOutputIsNotReadBackWhileThatDelaysHologramsInUse) {
  auto facts = running();
  EXPECT_EQ(why_not_verify(facts), "");
  for (const char* loop : {"closed", "paused"}) {
    (*facts.status)["loop"] = loop;
    EXPECT_NE(why_not_verify(facts).find("while the loop is closed"), std::string::npos) << loop;
  }
  (*facts.status)["loop"] = "open";
  (*facts.status)["state"] = "job_running";
  EXPECT_NE(why_not_verify(facts).find("while a job runs"), std::string::npos);
}

TEST(DoctorDaemon, AStatusOfAnotherStructureIsJudgedWithoutItsKeys) {
  auto facts = running();
  facts.status = nlohmann::json::array();
  expect(facts, "daemon.version", Severity::warning);
  facts.status = nlohmann::json{{"camera", 3}, {"state", 5}};
  expect(facts, "daemon.job", Severity::good);
  expect(facts, "camera.state", Severity::not_here);
}

}  // namespace
}  // namespace ovws::examine
