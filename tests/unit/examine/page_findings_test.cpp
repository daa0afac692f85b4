#include "daemon/examine/status_questions.hpp"

#include <gtest/gtest.h>

#include <set>

#include "daemon/shared/client.hpp"

namespace ovws::examine {
namespace {

using nlohmann::json;

class PageFindings : public testing::Test {
 protected:
  DaemonFacts facts;

  PageFindings() {
    const json device{{"connected", true}, {"fault", nullptr}};
    facts.is_followed = true;
    facts.status = json{{"state", "running"},
                        {"fault", nullptr},
                        {"camera", device},
                        {"slm", device},
                        {"sensor", {{"referenced", true}, {"reference", "in_force"}}}};
    (*facts.status)["slm"]["pattern"] = "sensor";
    facts.wavefront = {{"valid", true},      {"settled", true}, {"saturated", 0.0},
                       {"subapertures", 19}, {"tracked", 19},   {"verdict", "valid"}};
  }

  void expect_worst(Severity severity, const std::string& text) const {
    const auto found = page_findings(facts);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().severity, severity) << found.front().text;
    EXPECT_NE(found.front().text.find(text), std::string::npos) << found.front().text;
  }

  /// The image that the camera now sends has no measurement plan.
  void make_unmeasurable() {
    (*facts.status)["sensor"]["measurable"] = false;
    (*facts.status)["sensor"]["invalid"] = {
        {"reason", "the camera's image cannot be measured: why"},
        {"action", "change the region (camera.set)"}};
  }
};

TEST_F(PageFindings, IsWellWhenNothingIsWrong) {
  expect_worst(Severity::good, "OK");
  EXPECT_EQ(page_findings(facts).size(), 1U);
}

TEST_F(PageFindings, OffersOnlyCommandsThatThePageMayCall) {
  facts.wavefront["saturated"] = 0.5;
  (*facts.status)["sensor"]["reference"] = "stale";
  (*facts.status)["sensor"]["reference_introduced_rms_waves"] = 0.3;
  (*facts.status)["sensor"]["layout_fault"] = "spots lie outside the region";
  facts.lost_lately = facts.missed_lately = 1;
  auto found = page_findings(facts);
  EXPECT_EQ(found.size(), 6U);
  (*facts.status)["sensor"]["referenced"] = false;
  for (const auto& finding : page_findings(facts)) found.push_back(finding);
  (*facts.status)["slm"]["pattern"] = "grating";
  facts.wavefront["valid"] = false;
  for (const auto& finding : page_findings(facts)) found.push_back(finding);
  std::set<std::string> methods;
  for (const Finding& finding : found) {
    ASSERT_TRUE(finding.action.is_object()) << finding.text;
    EXPECT_FALSE(finding.action.at("label").get<std::string>().empty());
    EXPECT_NE(finding.action.contains("section"), finding.action.contains("calls"));
    for (const json& call : finding.action.value("calls", json::array())) {
      methods.insert(call.at("method"));
    }
  }
  EXPECT_EQ(methods, (std::set<std::string>{"aberration.clear", "camera.auto_exposure",
                                            "reference.take", "slm.show"}));
}

TEST_F(PageFindings, SilenceIsBad) {
  facts.status_age_s = 4.0;
  expect_worst(Severity::bad, "silent");
  expect_worst(Severity::bad, "ovwsd");
  DaemonFacts never_heard;
  never_heard.is_followed = true;
  EXPECT_EQ(page_findings(never_heard).front().severity, Severity::bad);
}

TEST_F(PageFindings, ADeviceThatIsNotThereIsBad) {
  (*facts.status)["camera"]["connected"] = false;
  expect_worst(Severity::bad, "Camera");
  (*facts.status)["slm"]["fault"] = "the output has another mode";
  expect_worst(Severity::bad, "Camera");
  EXPECT_EQ(page_findings(facts).size(), 2U);
}

TEST_F(PageFindings, AFrameThatCameLateIsNotAChangingHologram) {
  facts.wavefront["valid"] = facts.wavefront["settled"] = false;
  facts.wavefront["verdict"] = "late";
  expect_worst(Severity::note, "late");
  facts.wavefront["verdict"] = "changing";
  expect_worst(Severity::note, "hologram changing");
}

TEST_F(PageFindings, ADarkImageIsSaidWithTheExposureAsRemedy) {
  (*facts.status)["camera"]["brightest"] = 0.04;
  expect_worst(Severity::warning, "dark: its brightest pixels reach 4.0 %");
  EXPECT_EQ(page_findings(facts).front().action.at("calls").at(0).at("method"),
            "camera.auto_exposure");
  (*facts.status)["camera"]["brightest"] = nullptr;
  EXPECT_EQ(page_findings(facts).front().severity, Severity::good);
}

TEST_F(PageFindings, ACameraThatIsSlowForSecondsIsAWarning) {
  (*facts.status)["rates"] = {{"grabbed_hz", 71.3}, {"expected_hz", 100.0}};
  (*facts.status)["camera"]["settings"] = {{"frame_rate_hz", 100.0}, {"exposure_us", 2000.0}};
  facts.slow_statuses = 2;
  EXPECT_EQ(page_findings(facts).front().severity, Severity::good);
  facts.slow_statuses = 3;
  expect_worst(Severity::warning,
               "The camera sends 71.3 of 100 frames/s: the exposure leaves time");
  (*facts.status)["camera"]["settings"]["exposure_us"] = 13000.0;
  expect_worst(Severity::warning, "frames/s: the exposure fills the time between frames");
  (*facts.status)["rates"]["expected_hz"] = nullptr;
  EXPECT_EQ(page_findings(facts).front().severity, Severity::good);
  (*facts.status)["rates"] = {{"grabbed_hz", 99.0}, {"expected_hz", 100.0}};
  EXPECT_EQ(page_findings(facts).front().severity, Severity::good);
}

TEST_F(PageFindings, FramesThatStoppedAreBad) {
  facts.wavefront_age_s = 2.0;
  expect_worst(Severity::bad, "frames");
}

TEST_F(PageFindings, AFaultOfTheDaemonIsReported) {
  (*facts.status)["state"] = "fault";
  (*facts.status)["fault"] = "gain_db: refused";
  expect_worst(Severity::bad, "gain_db: refused");
}

TEST_F(PageFindings, SaysWhatToDoWithoutAReference) {
  (*facts.status)["sensor"]["referenced"] = false;
  facts.wavefront["valid"] = false;
  expect_worst(Severity::warning, "No reference");
  (*facts.status)["sensor"]["invalid"] = {{"reason", "it was taken with another camera"},
                                          {"action", "take a new reference"}};
  expect_worst(Severity::warning, "No reference: it was taken with another camera");
}

TEST_F(PageFindings, AnImageThatCannotBeMeasuredIsNotASilentCamera) {
  make_unmeasurable();
  const std::string why =
      "the camera's image cannot be measured: why; change the region (camera.set)";
  facts.wavefront_age_s = 60.0;  // each frame has an unexpected size
  expect_worst(Severity::bad, "No wavefront: " + why);
  facts.wavefront = nullptr;
  expect_worst(Severity::bad, "No wavefront: " + why);
  EXPECT_EQ(page_findings(facts).size(), 1U);
}

TEST_F(PageFindings, AnImageThatCannotBeMeasuredNeedsNoReference) {
  make_unmeasurable();
  facts.wavefront["valid"] = facts.wavefront["settled"] = false;
  for (const bool referenced : {true, false}) {
    (*facts.status)["sensor"]["referenced"] = referenced;
    (*facts.status)["sensor"]["reference"] = referenced ? "stale" : "none";
    expect_worst(Severity::bad, "No wavefront: the camera's image cannot be measured");
    EXPECT_EQ(page_findings(facts).size(), 1U);
    EXPECT_EQ(page_findings(facts).front().action.at("section"), "camera");
  }
  EXPECT_NE(cli::why_not_valid(facts.wavefront, *facts.status).find("cannot be measured"),
            std::string::npos);
}

TEST_F(PageFindings, AReferenceThatHoldsAnIntroducedAberrationIsNotWell) {
  (*facts.status)["sensor"]["reference_introduced_rms_waves"] = 0.0;
  expect_worst(Severity::good, "OK");
  (*facts.status)["sensor"]["reference_introduced_rms_waves"] = 0.3;
  expect_worst(Severity::warning, "introduced aberration of 0.3000 wave RMS");
}

TEST_F(PageFindings, AHologramThatIsChangingIsNoFault) {
  facts.wavefront["valid"] = false;
  facts.wavefront["settled"] = false;
  facts.wavefront["verdict"] = "changing";
  expect_worst(Severity::note, "changing");
  facts.wavefront["settled"] = true;
  facts.wavefront["verdict"] = "unexplained";
  expect_worst(Severity::bad, "explains");
}

TEST_F(PageFindings, SaysWhatIsDoneAboutInvalidFrames) {
  facts.wavefront["valid"] = false;
  facts.wavefront["tracked"] = 7;
  facts.wavefront["verdict"] = "spots_lost";
  (*facts.status)["sensor"]["invalid"] = {
      {"action", "the whole image is being searched for spots"}};
  expect_worst(Severity::bad, "7 of 19 spots are found; the whole image is being searched");
  facts.wavefront["verdict"] = "unexplained";
  expect_worst(Severity::bad,
               "7 of 19 spots are found, but no wavefront explains their positions; the whole");
  facts.wavefront["verdict"] = "too_close";
  expect_worst(Severity::bad, "7 of 19 spots are found, but too close to those of another source;");
  (*facts.status)["sensor"]["invalid"]["reason"] = "too close to those of the source red";
  expect_worst(Severity::bad, "No wavefront: too close to those of the source red; the whole");
}

TEST_F(PageFindings, CountsSaturatedAndLostSpots) {
  facts.wavefront["saturated"] = 1.0 / 19.0;
  expect_worst(Severity::note, "1 of 19 spots are saturated");
  facts.wavefront["saturated"] = 4.0 / 19.0;
  expect_worst(Severity::warning, "4 of 19 spots are saturated");
  facts.wavefront["saturated"] = 0.0;
  facts.wavefront["tracked"] = 17;
  expect_worst(Severity::warning, "2 of 19 spots lost");
}

TEST_F(PageFindings, ASaturatedSpotDoesNotHideThatTheImageIsDark) {
  facts.wavefront["saturated"] = 1.0 / 19.0;
  (*facts.status)["camera"]["brightest"] = 0.04;
  expect_worst(Severity::warning, "The image is dark");
  EXPECT_EQ(page_findings(facts).size(), 2U);
}

TEST_F(PageFindings, AReferenceIsJudgedWithoutDevices) {
  (*facts.status)["slm"]["connected"] = false;
  (*facts.status)["sensor"]["reference"] = "stale";
  (*facts.status)["sensor"]["reference_introduced_rms_waves"] = 0.3;
  EXPECT_EQ(page_findings(facts).size(), 3U);
}

TEST_F(PageFindings, ReportsLostAndLateFrames) {
  facts.lost_lately = 3;
  expect_worst(Severity::warning, "3 frames");
  facts.lost_lately = 1;
  expect_worst(Severity::warning, "lost 1 frame in");
  facts.lost_lately = 0;
  facts.missed_lately = 5;
  expect_worst(Severity::warning, "5 frames");
  facts.missed_lately = 1;
  expect_worst(Severity::warning, "1 frame took");
}

TEST_F(PageFindings, AnotherPatternIsNoFault) {
  (*facts.status)["slm"]["pattern"] = "grating";
  facts.wavefront["valid"] = false;
  facts.wavefront["tracked"] = 0;
  expect_worst(Severity::note, "grating");
}

TEST(RiseLatelyTest, ForgetsWhatIsLongAgoAndAnOlderDaemon) {
  RiseLately rise;
  EXPECT_EQ(rise.rise(), 0);
  rise.add(0.0, 100);
  EXPECT_EQ(rise.rise(), 0);
  rise.add(1.0, 107);
  EXPECT_EQ(rise.rise(), 7);
  for (int t = 2; t < 20; ++t) rise.add(t, 107);
  EXPECT_EQ(rise.rise(), 0);
  rise.add(20.0, 3);
  EXPECT_EQ(rise.rise(), 0);
}

}  // namespace
}  // namespace ovws::examine
