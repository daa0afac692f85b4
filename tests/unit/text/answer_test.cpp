#include "daemon/ovws/text/answer.hpp"

#include <gtest/gtest.h>

#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

TEST(Answer, EveryExampleOfEveryResultHasText) {
  for (const Schema& one : schemas()) {
    if (!one.json.contains("result")) continue;
    for (const json& result : one.json.at("result").value("examples", json::array())) {
      const std::string text = answer_text(one.name, result);
      EXPECT_FALSE(text.empty()) << one.name;
      EXPECT_NE(text.back(), '\n') << one.name;
    }
  }
}

TEST(Answer, TheLabReadsSentences) {
  const json& camera = schema("camera.get").at("result").at("examples").at(0);
  EXPECT_EQ(answer_text("camera.get", camera),
            "exposure 2 ms, gain 0 dB, 100 frames/s, Mono8, region 512 x 512 at (0, 0)");
  EXPECT_EQ(exposure_text(camera.at("settings"), camera.at("limits")),
            "2 ms (the camera allows 10 us to 1 s)");
  json lut = schema("lut.get").at("result").at("examples").at(0);
  lut["depth_rad"] = 6.2475, lut["residual_rad"] = 0.00103, lut["reason"] = nullptr;
  lut["falls"] = false, lut["reaches_2pi"] = true;
  EXPECT_EQ(answer_text("lut.run", lut), "LUT: 1.99 pi deep, error 1 mrad");
  EXPECT_EQ(answer_text("aberration.sequence",
                        {{"modes", json::array()}, {"patterns", {json::object(), json::object()}}}),
            "a sequence of patterns is shown: 2");
  EXPECT_EQ(answer_text("aberration.clear", {{"modes", json::array()}}),
            "no aberration is introduced");
}

TEST(Answer, FocusSaysWhereToMoveTheCamera) {
  const auto mode = [](int n, int m, double waves) {
    return json{{"n", n}, {"m", m}, {"waves", waves}};
  };
  json focus{
      {"camera_shift_mm", 1.8},
      {"camera_shift_standard_error_mm", 0.002},
      {"defocus_waves", -0.547},
      {"defocus_standard_error_waves", 0.0006},
      {"flatness_defocus_waves", nullptr},
      {"modes", {mode(2, -2, 0.03), mode(2, 0, -0.547), mode(2, 2, 0.04), mode(3, 1, 0.01)}}};
  EXPECT_EQ(answer_text("focus.run", focus),
            "the camera is 1.800 mm behind the focus: move it towards the lens by 1.800 mm\n"
            "defocus -0.5470 wave RMS (standard error 0.0006), astigmatism 0.0500, coma 0.0100, "
            "spherical aberration 0.0000");
  focus["camera_shift_mm"] = -0.2, focus["flatness_defocus_waves"] = 0.1;
  const std::string before = answer_text("focus.run", focus);
  EXPECT_TRUE(before.starts_with(
      "the camera is 0.200 mm in front of the focus: move it away from the lens by 0.200 mm\n"));
  EXPECT_NE(before.find("+0.1000 wave of defocus that the flatness compensates"), before.npos);
  focus["camera_shift_mm"] = -0.003, focus["defocus_waves"] = -0.00002;
  EXPECT_TRUE(answer_text("focus.run", focus)
                  .starts_with("the camera is in focus, within 0.010 mm\ndefocus 0.0000 wave RMS"));
}

TEST(Answer, OtherResultsHaveALineForEachKey) {
  EXPECT_EQ(summary_text({{"b_hz", 2.5},
                          {"a", {{"inner", true}, {"none", nullptr}}},
                          {"list", {1, 2}},
                          {"long", json::array({1, 2, 3, 4, 5, 6, 7, 8, 9})},
                          {"t_ns", 1}}),
            "a.inner  yes\nb_hz     2.5\nlist     1, 2\nlong     (9 entries)");
}

TEST(Answer, AForeignResultIsAnError) {
  EXPECT_THROW(answer_text("camera.get", json::object()), json::exception);
}

}  // namespace
}  // namespace ovws::cli
