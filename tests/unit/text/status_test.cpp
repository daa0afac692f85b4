#include "daemon/ovws/text/status.hpp"

#include <gtest/gtest.h>

#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

json example(const char* method) {
  return schema(method).at("result").at("examples").at(0);
}

BenchState bench() {
  return {schema("stream.status").at("examples").at(0),
          example("loop.get"),
          example("aberration.get"),
          example("correction.get"),
          example("reference.get"),
          schema("stream.wavefront").at("examples").at(0),
          ""};
}

TEST(Status, SubjectsComeInReadingOrder) {
  const std::string text = status_text(bench());
  std::size_t last = 0;
  for (const char* subject : {"state ", "settings ", "sensor ", "reference ", "wavefront ",
                              "aberration ", "loop ", "recording ", "losses "}) {
    const auto at = text.find(std::string("\n") + subject);
    const auto found = text.starts_with(subject) ? 0 : at;
    ASSERT_NE(found, std::string::npos) << subject << text;
    EXPECT_GE(found, last) << subject;
    last = found;
  }
  EXPECT_NE(text.find("exposure"), std::string::npos);
  EXPECT_NE(text.find("% saturated"), std::string::npos);
}

TEST(Status, EveryFurtherSourceHasALine) {
  BenchState state = bench();
  state.status["sensor"]["beams"] = {
      {{"name", "b"}, {"offset_px", {3.0, 418.04}}, {"referenced", true}, {"reason", nullptr}},
      {{"name", "c"}, {"offset_px", {0.0, -848.0}}, {"referenced", false}, {"reason", nullptr}},
      {{"name", "d"}, {"offset_px", {9.0, 9.0}}, {"referenced", true}, {"reason", "0 of 7 spots"}}};
  const std::string text = status_text(state);
  EXPECT_NE(text.find("\nbeam       b at (+3.0, +418.0) px: valid\n"), std::string::npos) << text;
  EXPECT_NE(text.find("c at (+0.0, -848.0) px: no reference\n"), std::string::npos) << text;
  EXPECT_NE(text.find("d at (+9.0, +9.0) px: NOT VALID: 0 of 7 spots\n"), std::string::npos)
      << text;
  state.wavefront["settled"] = false;  // another pattern is shown
  EXPECT_NE(status_text(state).find("b at (+3.0, +418.0) px: not measured now\n"),
            std::string::npos);
}

TEST(Status, AFixedArrayHasNoHologram) {
  BenchState state = bench();
  state.status["slm"]["info"]["output"] = "none";
  EXPECT_NE(status_text(state).find("\nslm        none: a fixed array of lenslets\n"),
            std::string::npos);
}

TEST(Status, AFrameThatIsNotValidSaysWhy) {
  BenchState state = bench();
  state.wavefront["valid"] = false;
  state.not_valid = "no reference";
  EXPECT_NE(status_text(state).find("wavefront  NOT VALID: no reference; "), std::string::npos);
  state.wavefront = nullptr;
  EXPECT_NE(status_text(state).find("wavefront  no frame is published"), std::string::npos);
}

TEST(Status, ADarkImageIsSaid) {
  BenchState state = bench();
  state.status["camera"]["brightest"] = nullptr;
  EXPECT_EQ(status_text(state).find("full scale"), std::string::npos);
  state.status["camera"]["brightest"] = 0.7;
  EXPECT_NE(status_text(state).find("brightest pixels at 70.0 % of full scale\n"),
            std::string::npos);
  state.status["camera"]["brightest"] = 0.012;
  EXPECT_NE(status_text(state).find("at 1.2 % of full scale: DARK; ovws exposure auto"),
            std::string::npos);
}

TEST(Status, TooMuchLightIsSaid) {
  BenchState state = bench();
  state.wavefront["saturated"] = 0.1;
  EXPECT_EQ(status_text(state).find("TOO BRIGHT"), std::string::npos);
  state.wavefront["saturated"] = 1.0;
  EXPECT_NE(
      status_text(state).find("100 % saturated: TOO BRIGHT; ovws exposure auto, or a lower gain\n"),
      std::string::npos)
      << status_text(state);
}

TEST(Status, ASlowCameraIsSaidWithWhatLimitsIt) {
  BenchState state = bench();
  const auto rate_of = [&](double measured_hz, double set_hz, double exposure_us) {
    state.status["rates"]["grabbed_hz"] = measured_hz;
    state.status["rates"]["expected_hz"] = set_hz;
    state.status["camera"]["settings"]["exposure_us"] = exposure_us;
    EXPECT_NE(status_text(state).find(measured_rate_text(state.status) + "\n"), std::string::npos)
        << status_text(state);
    return measured_rate_text(state.status);
  };
  EXPECT_EQ(rate_of(99.2, 100.0, 2000.0), "99.2 frames/s");
  EXPECT_EQ(rate_of(88.0, 100.0, 2000.0), "88.0 frames/s") << "two frames may be late";
  EXPECT_EQ(rate_of(1.0, 2.0, 2000.0), "1.0 frames/s");
  EXPECT_EQ(rate_of(0.0, 100.0, 2000.0), "0.0 frames/s") << "no frames are another fault";
  EXPECT_EQ(rate_of(71.3, 100.0, 2000.0),
            "71.3 frames/s of 100: SLOW; the exposure leaves time for more: check the camera's "
            "link and limits (ovws doctor), or lower the frame rate");
  EXPECT_EQ(rate_of(71.3, 100.0, 13000.0),
            "71.3 frames/s of 100: SLOW; the exposure fills the time between frames: shorten it, "
            "or lower the frame rate");
  EXPECT_EQ(rate_of(1234.0, 20000.0, 2.0).substr(0, 33), "1234.0 frames/s of 20000: SLOW; t");
  state.status["rates"]["expected_hz"] = nullptr;
  EXPECT_EQ(measured_rate_text(state.status), "1234.0 frames/s");
}

TEST(Status, TheLargestModesOfACorrectionAndHowToRemoveIt) {
  BenchState state = bench();
  const auto correct = [&](const std::vector<double>& waves) {
    state.correction["modes"] = json::array();
    for (std::size_t k = 0; k < waves.size(); ++k) {
      state.correction["modes"].push_back(
          {{"j", k + 4}, {"name", "m" + std::to_string(k)}, {"waves", waves[k]}});
    }
    const std::string text = status_text(state);
    const auto at = text.find("\ncorrection ");
    return at == std::string::npos ? "" : text.substr(at + 12, text.find('\n', at + 1) - at - 12);
  };
  state.loop["closed"] = false;
  EXPECT_EQ(correct({}), "");
  EXPECT_EQ(correct({0.03, 0.0004, -0.04}),
            "0.0500 wave RMS, m2 -0.0400, m0 +0.0300, …; remove it with: ovws loop "
            "clear");
  const std::string many = correct({0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.2});
  EXPECT_NE(many.find("m7 +0.2000, m0"), std::string::npos) << many;
  EXPECT_EQ(many.find("m5"), std::string::npos) << many;
  state.loop["closed"] = true;
  EXPECT_EQ(correct({0.05}), "0.0500 wave RMS, m0 +0.0500");
}

TEST(Status, TheAgeIsThatOfTheDaemon) {
  BenchState state = bench();
  state.status["state"] = "waiting_for_camera";
  state.status["uptime_s"] = 578.0;
  EXPECT_TRUE(status_text(state).starts_with(
      "state      waiting_for_camera; the daemon started 9 min 38 s ago"))
      << status_text(state);
}

TEST(Status, OnlyLossesAreCounted) {
  BenchState state = bench();
  state.status["counters"] = {{"frames_grabbed", 1000}, {"requests", 7}, {"frames_lost", 0}};
  EXPECT_NE(status_text(state).find("losses     none since the start"), std::string::npos);
  state.status["counters"]["frames_lost"] = 3;
  EXPECT_NE(status_text(state).find("losses     frames_lost 3 since the start"), std::string::npos);
}

TEST(Status, AForeignStatusIsAnError) {
  BenchState state = bench();
  state.status = json::object();
  EXPECT_THROW(status_text(state), json::exception);
}

}  // namespace
}  // namespace ovws::cli
