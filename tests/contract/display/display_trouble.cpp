/// Display contract in case of faults: wrong outputs are refused, and changes are detected.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "tests/contract/display/bench.hpp"

// Last: Xlib has macros like None that would break the others.
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/extensions/Xrandr.h>

namespace ovws::test {
namespace {

constexpr double kNoticeS = 2.5;  // outputs are verified once a second

bool has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

/// Restores the outputs after each test.
class DisplayTrouble : public testing::Test {
 protected:
  void SetUp() override { original_display_ = std::getenv("DISPLAY"); }
  void TearDown() override {
    setenv("DISPLAY", original_display_.c_str(), 1);
    unsetenv("SDL_VIDEODRIVER");
    run("xrandr --output DUMMY0 --mode 1920x1080 --pos 0x0 --primary "
        "--output DUMMY1 --mode 1280x768 --pos 1920x0 --gamma 1");
    for (const char* output : {"DUMMY0", "DUMMY1"}) set_monitor_name(output, "");
  }

  static Error refused(const SdlConfig& config) {
    const auto display = open_sdl_display(config);
    EXPECT_FALSE(display);
    return display ? Error{} : display.error();
  }

  /// Sets the EDID of a monitor of this name on the output; an empty name removes it.
  static void set_monitor_name(const std::string& output, std::string_view name) {
    ::Display* server = XOpenDisplay(nullptr);
    ASSERT_NE(server, nullptr);
    XRRScreenResources* all = XRRGetScreenResourcesCurrent(server, DefaultRootWindow(server));
    const Atom property = XInternAtom(server, RR_PROPERTY_RANDR_EDID, False);
    for (int i = 0; i < all->noutput; ++i) {
      XRROutputInfo* info = XRRGetOutputInfo(server, all, all->outputs[i]);
      if (output == info->name && name.empty()) {
        XRRDeleteOutputProperty(server, all->outputs[i], property);
      } else if (output == info->name) {
        const auto edid = make_edid(name);
        XRRChangeOutputProperty(server, all->outputs[i], property, XA_INTEGER, 8, PropModeReplace,
                                edid.data(), int(edid.size()));
      }
      XRRFreeOutputInfo(info);
    }
    XRRFreeScreenResources(all);
    XCloseDisplay(server);
  }

 private:
  // The second of the four descriptors holds the name; the first is a mode.
  static std::vector<unsigned char> make_edid(std::string_view name) {
    std::vector<unsigned char> edid(128, 0);
    edid[54] = 1;
    edid[72 + 3] = 0xFC;
    auto end = std::ranges::copy(name, edid.begin() + 72 + 5).out;
    if (name.size() < 13) *end++ = '\n';
    std::fill(end, edid.begin() + 90, static_cast<unsigned char>(' '));
    return edid;
  }

  std::string original_display_;
};

TEST_F(DisplayTrouble, AnUnknownOutputIsUnavailableAndThoseThereAreListed) {
  auto config = slm_config();
  config.output = "HDMI-7";
  const Error error = refused(config);
  EXPECT_EQ(error.code, Errc::unavailable);
  EXPECT_EQ(error.field, "slm.display");
  EXPECT_TRUE(has(error.reason, "HDMI-7")) << error.reason;
  EXPECT_TRUE(has(error.reason, "DUMMY0 1920x1080 (primary), DUMMY1 1280x768")) << error.reason;
  EXPECT_FALSE(has(error.reason, "DUMMY2")) << error.reason;
}

TEST_F(DisplayTrouble, AnIndexIsNotAcceptedAsAnOutputsName) {
  auto config = slm_config();
  config.output = "1";
  EXPECT_EQ(refused(config).code, Errc::unavailable);
}

TEST_F(DisplayTrouble, AnotherSizeIsRefusedWithBothSizesAndTheRemedy) {
  auto config = slm_config();
  config.width = 1920;
  Error error = refused(config);
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_EQ(error.field, "slm.width");
  EXPECT_TRUE(has(error.reason, "1280x768")) << error.reason;
  EXPECT_TRUE(has(error.reason, "xrandr --output DUMMY1 --mode 1920x768")) << error.reason;
  config = slm_config();
  config.height = 1024;
  error = refused(config);
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_EQ(error.field, "slm.height");
}

TEST_F(DisplayTrouble, ThePrimaryOutputIsRefusedUnlessAllowed) {
  SdlConfig config{.output = "DUMMY0", .width = 1280, .height = 768, .allow_primary = false};
  const Error error = refused(config);  // independent of its size
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_TRUE(has(error.reason, "DUMMY0 is the primary output")) << error.reason;
  EXPECT_TRUE(has(error.reason, "DUMMY1 1280x768")) << error.reason;
  config.width = 1920;
  config.height = 1080;
  config.allow_primary = true;
  const auto display = open_or_fail(config);
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(1, 1920, 1080);
  ASSERT_TRUE(display->present(picture));
  EXPECT_EQ(wrong_pixels(picture, 0, 0), 0);
}

TEST_F(DisplayTrouble, TheOnlyOutputIsRefusedUnlessAllowed) {
  run("xrandr --output DUMMY0 --off --noprimary");
  auto config = slm_config();
  const Error error = refused(config);
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_TRUE(has(error.reason, "only output")) << error.reason;
  config.allow_primary = true;
  EXPECT_NE(open_or_fail(config), nullptr);
}

TEST_F(DisplayTrouble, AnOutputThatMirrorsAnotherIsRefused) {
  run("xrandr --output DUMMY1 --same-as DUMMY0");
  const Error error = refused(slm_config());
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_TRUE(has(error.reason, "DUMMY0")) << error.reason;
}

TEST_F(DisplayTrouble, AnOutputThatIsOffIsRefusedAndOneWithoutMonitorIsUnavailable) {
  run("xrandr --output DUMMY1 --off");
  const Error off = refused(slm_config());
  EXPECT_EQ(off.code, Errc::refused);
  EXPECT_TRUE(has(off.reason, "switched off")) << off.reason;
  auto config = slm_config();
  config.output = "DUMMY2";
  EXPECT_EQ(refused(config).code, Errc::unavailable);
}

TEST_F(DisplayTrouble, TheMonitorsNameSelectsItsOutput) {
  set_monitor_name("DUMMY1", "LETO SLM");
  auto config = slm_config();
  config.output = "LETO SLM";
  const auto display = open_or_fail(config);
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(display->info().output, "DUMMY1");
  const auto picture = random_image(3);
  ASSERT_TRUE(display->present(picture));
  EXPECT_EQ(wrong_pixels(picture), 0);
}

TEST_F(DisplayTrouble, AMonitorsNameThatTwoHaveIsRefused) {
  set_monitor_name("DUMMY0", "PLUTO-2");
  set_monitor_name("DUMMY1", "PLUTO-2");
  auto config = slm_config();
  config.output = "PLUTO-2";
  const Error error = refused(config);
  EXPECT_EQ(error.code, Errc::refused);
  EXPECT_TRUE(has(error.reason, "DUMMY1 \"PLUTO-2\"")) << error.reason;
}

TEST_F(DisplayTrouble, WithoutAnyDisplaySystemItIsUnavailable) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const Error error = refused(slm_config());
  EXPECT_EQ(error.code, Errc::unavailable);
  EXPECT_TRUE(has(error.reason, "DISPLAY")) << error.reason;
}

TEST_F(DisplayTrouble, AServerThatDoesNotAnswerIsUnavailable) {
  setenv("DISPLAY", ":29999", 1);
  const Error error = refused(slm_config());
  EXPECT_EQ(error.code, Errc::unavailable);
  EXPECT_TRUE(has(error.reason, ":29999")) << error.reason;
}

TEST_F(DisplayTrouble, SdlDriversThatShowNothingAreUnavailable) {
  for (const char* driver : {"offscreen", "dummy", "nonsense"}) {
    setenv("SDL_VIDEODRIVER", driver, 1);
    const Error error = refused(slm_config());
    EXPECT_EQ(error.code, Errc::unavailable) << driver;
    EXPECT_TRUE(has(error.reason, driver)) << error.reason;
  }
}

TEST_F(DisplayTrouble, AnOutputSwitchedOffIsNoticed) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  ASSERT_EQ(watch(*display, 0.1), "");
  run("xrandr --output DUMMY1 --off");
  const std::string reason = watch(*display, kNoticeS);
  EXPECT_TRUE(has(reason, "DUMMY1 is switched off")) << reason;
}

TEST_F(DisplayTrouble, AnotherModeAndAnotherPlaceAreNoticed) {
  auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  run("xrandr --output DUMMY1 --mode 1024x768");
  std::string reason = watch(*display, kNoticeS);
  EXPECT_TRUE(has(reason, "1024x768")) << reason;
  display.reset();
  run("xrandr --output DUMMY1 --mode 1280x768");
  display = open_or_fail();
  ASSERT_NE(display, nullptr);
  run("xrandr --output DUMMY1 --pos 1920x100");
  reason = watch(*display, kNoticeS);
  EXPECT_TRUE(has(reason, "moved")) << reason;
}

TEST_F(DisplayTrouble, ABentGammaRampIsStraightenedAtOpeningAndNoticedLater) {
  run("xrandr --output DUMMY1 --gamma 1:0.9:0.7");
  auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(watch(*display, 1.5), "");
  run("xrandr --output DUMMY1 --gamma 1:0.9:0.7");
  const std::string reason = watch(*display, kNoticeS);
  EXPECT_TRUE(has(reason, "gamma")) << reason;
}

/// A window of another program over the SLM.
class Intruder {
 public:
  Intruder() : server_(XOpenDisplay(nullptr)) {
    window_ = XCreateSimpleWindow(server_, DefaultRootWindow(server_), kSlmX + 200, 200, 300, 200,
                                  0, 0, 0xff0000);
    XStoreName(server_, window_, "mail");
    XMapRaised(server_, window_);
    XSync(server_, False);
  }
  ~Intruder() { XCloseDisplay(server_); }
  Intruder(const Intruder&) = delete;
  Intruder& operator=(const Intruder&) = delete;

 private:
  ::Display* server_;
  Window window_;
};

TEST_F(DisplayTrouble, AWindowOverTheSlmIsNoticedByItsNameAndOpeningAgainIsOnTop) {
  auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const Intruder intruder;
  const std::string reason = watch(*display, kNoticeS);
  EXPECT_TRUE(has(reason, "\"mail\"")) << reason;
  display.reset();
  display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(4);
  ASSERT_TRUE(display->present(picture));
  EXPECT_EQ(wrong_pixels(picture), 0);
  EXPECT_EQ(watch(*display, 1.5), "");
}

/// Checks the display until the image is complete again, for 10 s at most.
template <class CountWrong>
bool is_redrawn(Display& display, CountWrong count_wrong) {
  for (int turn = 0; turn < 50; ++turn) {
    if (!watch(display, 0.2).empty()) return false;
    if (count_wrong() == 0) return true;
  }
  return false;
}

TEST_F(DisplayTrouble, WhatIsReadBackIsWhatStandsThereWhoeverDrewIt) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(6);
  ASSERT_TRUE(display->present(picture));
  const auto differing = [&] {
    const auto seen = display->read_back();
    if (!seen) return -1;
    int count = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      count += seen->pixels[i] != picture.pixels[i] * 0x010101U ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(differing(), 0);
  {
    const Intruder intruder;
    EXPECT_GT(differing(), 100);
  }
  EXPECT_TRUE(is_redrawn(*display, differing));
}

TEST_F(DisplayTrouble, AnUncoveredImageIsDrawnAgain) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(5);
  ASSERT_TRUE(display->present(picture));
  { const Intruder brief; }
  EXPECT_TRUE(is_redrawn(*display, [&] { return wrong_pixels(picture); }));
}

TEST_F(DisplayTrouble, AWindowDestroyedByAnotherProgramIsNoticed) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  ::Display* server = XOpenDisplay(nullptr);
  Window root = None, parent = None;
  Window* windows = nullptr;
  unsigned count = 0;
  ASSERT_TRUE(XQueryTree(server, DefaultRootWindow(server), &root, &parent, &windows, &count));
  ASSERT_GT(count, 0u);
  XDestroyWindow(server, windows[count - 1]);
  XFree(windows);
  XCloseDisplay(server);
  const auto shown = display->present(random_image(1));
  ASSERT_FALSE(shown);
  EXPECT_EQ(shown.error().code, Errc::device);
  EXPECT_TRUE(has(shown.error().reason, "Bad")) << shown.error().reason;
}

}  // namespace
}  // namespace ovws::test
