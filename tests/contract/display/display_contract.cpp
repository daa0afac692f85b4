/// Display contract in normal operation: the right output, exact pixels, correct times.
#include <gtest/gtest.h>
#include <signal.h>

#include "core/port/clock.hpp"
#include "tests/contract/display/bench.hpp"

// Last: Xlib has macros like None that would break the others.
#include <X11/Xlib.h>

namespace ovws::test {
namespace {

TEST(DisplayContract, InfoReportsOutputSizeRefreshAndDriver) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(display->info().output, "DUMMY1");
  EXPECT_EQ(display->info().width, 1280);
  EXPECT_EQ(display->info().height, 768);
  EXPECT_NEAR(display->info().refresh_hz, 59.87, 0.01);
  EXPECT_EQ(display->info().driver, "x11");
}

TEST(DisplayContract, ItIsBlackBeforeTheFirstImage) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(wrong_pixels(Image<std::uint8_t>(1280, 768)), 0);
}

TEST(DisplayContract, EveryPixelShownIsTheImagesPixel) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto picture = random_image(seed);
    ASSERT_TRUE(display->present(picture));
    EXPECT_EQ(wrong_pixels(picture), 0) << "of " << picture.pixels.size();
  }
}

TEST(DisplayContract, PresentTimesAreMonotonicAndInsideTheCall) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(1);
  std::int64_t before = monotonic_ns();
  for (int i = 0; i < 20; ++i) {
    const auto shown = display->present(picture);
    ASSERT_TRUE(shown);
    EXPECT_GT(*shown, before);
    EXPECT_LE(*shown, monotonic_ns());
    before = *shown;
  }
}

TEST(DisplayContract, AnImageOfAnotherSizeIsRefusedAndHarmsNothing) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto shown = display->present(random_image(1, 768, 1280));
  ASSERT_FALSE(shown);
  EXPECT_EQ(shown.error().code, Errc::invalid);
  const auto picture = random_image(2);
  EXPECT_TRUE(display->present(picture));
  EXPECT_EQ(wrong_pixels(picture), 0);
}

TEST(DisplayContract, CheckIsQuietWhileNothingHappens) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  EXPECT_EQ(watch(*display, 2.5), "");
}

TEST(DisplayContract, ASecondDisplayIsRefusedWhileOneIsOpen) {
  const auto display = open_or_fail();
  const auto second = open_sdl_display(slm_config());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::refused);
}

TEST(DisplayContract, NeitherTheFocusNorTheDesktopsPixelsChange) {
  ::Display* desktop = XOpenDisplay(nullptr);
  ASSERT_NE(desktop, nullptr);
  const Window root = DefaultRootWindow(desktop);
  const Window work = XCreateSimpleWindow(desktop, root, 100, 100, 400, 300, 0, 0, 0x808080);
  XMapWindow(desktop, work);
  XSync(desktop, False);
  XSetInputFocus(desktop, work, RevertToParent, CurrentTime);
  XSync(desktop, False);
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  ASSERT_TRUE(display->present(random_image(1)));
  ASSERT_TRUE(display->check());
  Window focused = None;
  int revert = 0;
  XGetInputFocus(desktop, &focused, &revert);
  EXPECT_EQ(focused, work);
  EXPECT_EQ(wrong_pixels(Image<std::uint8_t>(400, 300, 0x80), 100, 100), 0);
  XCloseDisplay(desktop);
}

TEST(DisplayContract, TheWindowIsOnTopAndOutOfAWindowManagersReach) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  ::Display* desktop = XOpenDisplay(nullptr);
  ASSERT_NE(desktop, nullptr);
  Window root = None, parent = None;
  Window* windows = nullptr;
  unsigned count = 0;
  ASSERT_TRUE(XQueryTree(desktop, DefaultRootWindow(desktop), &root, &parent, &windows, &count));
  ASSERT_GT(count, 0u);
  XWindowAttributes top{};
  ASSERT_TRUE(XGetWindowAttributes(desktop, windows[count - 1], &top));
  EXPECT_TRUE(top.override_redirect);
  EXPECT_EQ(top.x, kSlmX);
  EXPECT_EQ(top.y, 0);
  EXPECT_EQ(top.width, 1280);
  EXPECT_EQ(top.height, 768);
  XFree(windows);
  XCloseDisplay(desktop);
}

TEST(DisplayContract, ItStartsNoThreadAndLeavesSignalsToTheProgram) {
  for (const int number : {SIGTERM, SIGINT}) ::signal(number, SIG_DFL);  // a shell may ignore some
  const long threads = process_status("Threads");
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  ASSERT_TRUE(display->present(random_image(1)));
  EXPECT_EQ(process_status("Threads"), threads);
  struct sigaction action {};
  for (const int number : {SIGTERM, SIGINT}) {
    sigaction(number, nullptr, &action);
    EXPECT_EQ(action.sa_handler, SIG_DFL);
  }
}

TEST(DisplayContract, AThousandImagesTakeNoMemory) {
  const auto display = open_or_fail();
  ASSERT_NE(display, nullptr);
  const auto picture = random_image(1);
  const auto show = [&](int count) {
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(display->present(picture));
      ASSERT_TRUE(display->check());
    }
  };
  show(50);
  const long before_kb = process_status("VmRSS");
  show(1000);
  EXPECT_LT(process_status("VmRSS") - before_kb, 1000);
}

TEST(DisplayContract, OpeningItAgainAndAgainTakesNoMemory) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer keeps freed memory; it looks for leaks itself";
#endif
  const auto cycle = [](int count) {
    for (int i = 0; i < count; ++i) ASSERT_NE(open_or_fail(), nullptr);
  };
  cycle(5);
  const long before_kb = process_status("VmRSS");
  cycle(30);
  EXPECT_LT(process_status("VmRSS") - before_kb, 2000);
}

}  // namespace
}  // namespace ovws::test
