/// Death of the X server: an error that never ends this process, and from which the display
/// recovers.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <random>
#include <thread>

#include "tests/contract/display/bench.hpp"
#include "tests/support/xorg_server.hpp"

namespace ovws::test {
namespace {

class DisplayServerDeath : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::signal(SIGPIPE, SIG_IGN);  // as ovwsd does: the server's end closes a socket
  }

  void start() {
    server.reset();
    server.emplace(number);
    setenv("DISPLAY", server->name().c_str(), 1);
  }

  void expect_it_shows(unsigned seed) {
    const auto display = open_or_fail();
    ASSERT_NE(display, nullptr);
    const auto picture = random_image(seed);
    ASSERT_TRUE(display->present(picture));
    EXPECT_EQ(wrong_pixels(picture), 0);
    EXPECT_TRUE(display->check());
  }

  std::optional<XorgServer> server;
  const int number = 1000 + getpid() % 20'000;  // not assigned to others by -displayfd
};

TEST_F(DisplayServerDeath, PresentGivesAnErrorAndANewServerOfTheSameNumberIsUsed) {
  for (unsigned round = 0; round < 3; ++round) {
    start();
    {
      const auto display = open_or_fail();
      ASSERT_NE(display, nullptr);
      ASSERT_TRUE(display->present(random_image(round)));
      server->kill();
      const auto shown = display->present(random_image(round));
      ASSERT_FALSE(shown);
      EXPECT_EQ(shown.error().code, Errc::device);
      EXPECT_FALSE(display->check());
      EXPECT_FALSE(display->present(random_image(round)));
    }
    const auto absent = open_sdl_display(slm_config());
    ASSERT_FALSE(absent);
    EXPECT_EQ(absent.error().code, Errc::unavailable);
  }
  start();
  expect_it_shows(9);
}

TEST_F(DisplayServerDeath, CheckAloneNoticesItWithinTwoSeconds) {
  start();
  {
    const auto display = open_or_fail();
    ASSERT_NE(display, nullptr);
    EXPECT_EQ(watch(*display, 0.1), "");
    server->kill();
    EXPECT_NE(watch(*display, 2.0), "");
  }
  start();
  expect_it_shows(10);
}

TEST_F(DisplayServerDeath, ADisplayDestroyedAfterTheServerDiedUnseenIsHarmless) {
  start();
  {
    const auto display = open_or_fail();
    ASSERT_NE(display, nullptr);
    server->kill();
  }
  start();
  expect_it_shows(11);
}

TEST_F(DisplayServerDeath, TheServerMayDieAtAnyMomentOfShowing) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> moment_us(0, 20'000);
  const auto picture = random_image(1);
  for (int round = 0; round < 15; ++round) {
    start();
    const auto display = open_or_fail();
    ASSERT_NE(display, nullptr);
    std::thread killer([&, wait = std::chrono::microseconds(moment_us(random))] {
      std::this_thread::sleep_for(wait);
      server->kill();
    });
    while (display->present(picture) && display->check()) continue;
    killer.join();
  }
  start();
  expect_it_shows(12);
}

}  // namespace
}  // namespace ovws::test
