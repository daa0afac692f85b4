/// Probe of the X server: its results are correct, and it changes nothing.
#include <gtest/gtest.h>

#include <cstdlib>

#include "drivers/sdl/display_probe.hpp"
#include "tests/contract/display/bench.hpp"

// Last: Xlib has macros like None that would break the others.
#include <X11/Xlib.h>

namespace ovws::test {
namespace {

TEST(DisplayProbe, ReportsOutputsAndThatNothingSwitchesThemOff) {
  const auto probe = sdl::probe_display();
  ASSERT_TRUE(probe) << probe.error().reason;
  ASSERT_GE(probe->outputs.size(), 2U);
  const auto slm = sdl::choose_output(probe->outputs, slm_config());
  ASSERT_TRUE(slm) << slm.error().reason;
  EXPECT_TRUE(slm->linear_gamma);
  EXPECT_EQ(probe->colour_depth_bits, 24);
  EXPECT_FALSE(probe->power_saving);
  EXPECT_FALSE(probe->asleep);
  EXPECT_EQ(probe->screen_saver_s, 0);
  EXPECT_FALSE(probe->composited);
}

// The X server of these tests has no DPMS, so only its absence is tested.
TEST(DisplayProbe, SeesTheScreenSaverAndLeavesItAsItIs) {
  run("xset s 600");
  EXPECT_EQ(sdl::probe_display()->screen_saver_s, 600);
  EXPECT_EQ(sdl::probe_display()->screen_saver_s, 600);
  run("xset s off");
  EXPECT_EQ(sdl::probe_display()->screen_saver_s, 0);
}

TEST(DisplayProbe, SeesABentGammaRampAndLeavesItBent) {
  run("xrandr --output DUMMY1 --gamma 2:2:2");
  for (int i = 0; i < 2; ++i) {
    const auto outputs = sdl::probe_display()->outputs;
    EXPECT_FALSE(sdl::choose_output(outputs, slm_config())->linear_gamma);
  }
  run("xrandr --output DUMMY1 --gamma 1:1:1");
  EXPECT_TRUE(sdl::choose_output(sdl::probe_display()->outputs, slm_config())->linear_gamma);
}

TEST(DisplayProbe, SeesACompositingManager) {
  ::Display* const server = XOpenDisplay(nullptr);
  ASSERT_NE(server, nullptr);
  const Window manager =
      XCreateSimpleWindow(server, DefaultRootWindow(server), 0, 0, 1, 1, 0, 0, 0);
  XSetSelectionOwner(server, XInternAtom(server, "_NET_WM_CM_S0", False), manager, CurrentTime);
  XSync(server, False);
  EXPECT_TRUE(sdl::probe_display()->composited);
  XCloseDisplay(server);
  EXPECT_FALSE(sdl::probe_display()->composited);
}

TEST(DisplayProbe, SaysWhyItSeesNothing) {
  const std::string display = std::getenv("DISPLAY");
  setenv("DISPLAY", ":29998", 1);
  const auto silent = sdl::probe_display();
  setenv("SDL_VIDEODRIVER", "KMSDRM", 1);
  const auto other = sdl::probe_display();
  unsetenv("SDL_VIDEODRIVER");
  setenv("DISPLAY", display.c_str(), 1);
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, Errc::unavailable);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, Errc::refused);
}

}  // namespace
}  // namespace ovws::test
