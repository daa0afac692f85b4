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
  EXPECT_EQ(answer_text("aberration.clear", {{"modes", json::array()}}),
            "no aberration is introduced");
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
