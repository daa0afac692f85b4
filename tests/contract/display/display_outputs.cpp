/// Choice of the SLM's output: cases that an X server without hardware cannot produce.
#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "drivers/sdl/output.hpp"
#include "tests/contract/display/bench.hpp"

namespace ovws::test {
namespace {

sdl::Output desktop() {
  sdl::Output out;
  out.name = "DP-1";
  out.connected = out.primary = true;
  out.width = out.mode_width = 1920;
  out.height = out.mode_height = 1080;
  return out;
}

sdl::Output slm() {
  sdl::Output out;
  out.name = "DUMMY1";
  out.connected = true;
  out.x = 1920;
  out.width = out.mode_width = 1280;
  out.height = out.mode_height = 768;
  return out;
}

Errc code_of(const sdl::Output& output) {
  const auto chosen = sdl::choose_output({desktop(), output}, slm_config());
  return chosen ? Errc::internal : chosen.error().code;
}

TEST(DisplayOutputs, TheOneThatFitsIsChosen) {
  const auto chosen = sdl::choose_output({desktop(), slm()}, slm_config());
  ASSERT_TRUE(chosen);
  EXPECT_EQ(chosen->x, 1920);
}

TEST(DisplayOutputs, AScaledOrRotatedOneIsRefused) {
  auto scaled = slm();
  scaled.width *= 2;
  scaled.height *= 2;
  EXPECT_EQ(code_of(scaled), Errc::refused);
  auto rotated = slm();
  rotated.upright = false;
  EXPECT_EQ(code_of(rotated), Errc::refused);
}

TEST(DisplayOutputs, OneThatIsScaledToTheConfiguredSizeIsRefusedForItsMode) {
  auto scaled = slm();
  scaled.mode_width = 1920;
  scaled.mode_height = 1080;
  const auto chosen = sdl::choose_output({desktop(), scaled}, slm_config());
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().field, "slm.width");
}

TEST(DisplayOutputs, OneThatOverlapsTheDesktopByAPixelIsRefusedUnlessAllowed) {
  auto config = slm_config();
  auto shifted = slm();
  shifted.x = 1919;
  EXPECT_EQ(code_of(shifted), Errc::refused);
  config.allow_primary = true;
  EXPECT_TRUE(sdl::choose_output({desktop(), shifted}, config));
}

TEST(DisplayOutputs, AnOutputsNameGoesBeforeAMonitorsName) {
  auto other = desktop();
  other.monitor = "DUMMY1";
  const auto chosen = sdl::choose_output({other, slm()}, slm_config());
  ASSERT_TRUE(chosen);
  EXPECT_EQ(chosen->name, "DUMMY1");
}

TEST(DisplayOutputs, ANameThatTwoOutputsHaveIsRefused) {
  auto twin = slm();
  twin.x += twin.width;
  const auto chosen = sdl::choose_output({desktop(), slm(), twin}, slm_config());
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().code, Errc::refused);
}

TEST(DisplayOutputs, AnEmptyNameChoosesNothing) {
  auto config = slm_config();
  config.output = "";
  EXPECT_FALSE(sdl::choose_output({desktop(), slm()}, config));
}

TEST(DisplayOutputs, AnEdidThatIsShortOrFullOrNamelessIsReadSafely) {
  std::vector<std::uint8_t> edid(128, 0);
  EXPECT_EQ(sdl::edid_monitor_name({}), "");
  EXPECT_EQ(sdl::edid_monitor_name(edid), "");
  edid[108 + 3] = 0xFC;  // the last descriptor; all 13 letters used, so no line feed
  std::ranges::copy(std::string_view("HOLOEYE PLUTO"), edid.begin() + 108 + 5);
  EXPECT_EQ(sdl::edid_monitor_name(edid), "HOLOEYE PLUTO");
  edid.resize(127);
  EXPECT_EQ(sdl::edid_monitor_name(edid), "");
}

}  // namespace
}  // namespace ovws::test
