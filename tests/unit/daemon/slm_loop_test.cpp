/// SlmLoop: what it checks when it opens the display, and how it shares its time, with a fake
/// display. This program's own open_display replaces the driver table's.
#include "daemon/ovwsd/slm/slm_loop.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"
#include "proto/tables/slm.hpp"
#include "tests/support/time.hpp"

namespace ovws {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr int kAlways = 1'000'000;

/// What stands between the window and the output.
struct Compositor {
  int dims = 0;                             ///< images that it still shows at 70 %
  int pointer_px = 0;                       ///< pixels that it covers with white
  int panel_px = 0;                         ///< last pixels that it covers with black
  bool hides = false;                       ///< no image can be read
  std::chrono::milliseconds read_takes{0};  ///< simulated time
  int opened = 0, presented = 0, read = 0;
};
Compositor* compositor = nullptr;

class PlayedDisplay final : public Display {
 public:
  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& levels) override {
    shown_ = levels;
    ++compositor->presented;
    return std::int64_t{1};
  }
  Result<Image<std::uint32_t>> read_back() override {
    ++compositor->read;
    test::skip(compositor->read_takes);
    if (compositor->hides) return fail(Errc::unavailable, "slm.display", "it cannot be read");
    const bool dimmed = compositor->dims > 0;
    compositor->dims -= dimmed ? 1 : 0;
    Image<std::uint32_t> seen(kWidth, kHeight);
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
      const std::uint32_t level = dimmed ? shown_.pixels[i] * 7U / 10U : shown_.pixels[i];
      seen.pixels[i] = int(i) < compositor->pointer_px ? 0xffffffU : level * 0x010101U;
      if (int(i) >= kWidth * kHeight - compositor->panel_px) seen.pixels[i] = 0;
    }
    return seen;
  }
  Result<void> check() override { return {}; }

 private:
  DisplayInfo info_{"TEST", kWidth, kHeight, 60.0, "test"};
  Image<std::uint8_t> shown_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_display(const SlmConfig&) {
  ++compositor->opened;
  return std::make_unique<PlayedDisplay>();
}
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig&) {
  return fail(Errc::unavailable, "camera", "there is none");
}

namespace {

class Opening : public testing::Test {
 protected:
  Opening() { compositor = &compositor_; }
  ~Opening() override { compositor = nullptr; }

  /// Opens the display and presents a ramp of all levels, in one turn.
  SlmSnapshot opened() {
    Image<std::uint8_t> ramp(kWidth, kHeight);
    for (std::size_t i = 0; i < ramp.pixels.size(); ++i) ramp.pixels[i] = std::uint8_t(i);
    HologramRequest request;
    request.hologram_id = 7;
    request.sensor_epoch = 3;
    request.levels = std::make_shared<const Image<std::uint8_t>>(std::move(ramp));
    loop_.show_when_possible(std::move(request));
    loop_.do_work();
    shown_.update();
    return loop_.snapshot();
  }

  Compositor compositor_;
  Counters counters_;
  StreamQueue queue_;
  Events events_{queue_};
  LatestValue<ShownHologram> shown_;
  SlmLoop loop_{SlmConfig{}, {shown_, counters_, events_, [](const SlmSnapshot&) {}}};
};

TEST_F(Opening, ADisplayThatShowsTheLevelsIsReadOnce) {
  const SlmSnapshot now = opened();
  EXPECT_TRUE(now.healthy) << now.fault;
  EXPECT_EQ(now.hologram_id, 7U);
  EXPECT_EQ(compositor_.read, 1);
}

TEST_F(Opening, ADimmedWindowIsAFaultAndNoHologramCountsAsShown) {
  compositor_.dims = kAlways;
  compositor_.read_takes = std::chrono::seconds(1);
  const SlmSnapshot now = opened();
  EXPECT_FALSE(now.healthy);
  EXPECT_TRUE(now.at_fault);
  EXPECT_NE(now.fault.find("level 255 is shown as 178"), std::string::npos) << now.fault;
  EXPECT_NE(now.fault.find("compositor"), std::string::npos) << now.fault;
  EXPECT_FALSE(shown_.value().healthy);
  EXPECT_EQ(shown_.value().current.hologram_id, 0U);
  EXPECT_EQ(compositor_.opened, 1);
  EXPECT_EQ(compositor_.read, 5);
}

TEST_F(Opening, AWindowThatFadesInIsWaitedForHoweverLongEachReadTakes) {
  compositor_.dims = 3;
  compositor_.read_takes = std::chrono::seconds(1);
  const SlmSnapshot now = opened();
  EXPECT_TRUE(now.healthy) << now.fault;
  EXPECT_EQ(compositor_.read, 4);
}

TEST_F(Opening, APointerOnTheOutputIsNoFault) {
  compositor_.pointer_px = kWidth * kHeight / 100;
  EXPECT_TRUE(opened().healthy);
}

TEST_F(Opening, AFaultQuotesTheLevelThatDiffersMost) {
  compositor_.panel_px = kWidth * kHeight / 20;  // not over the first pixel of level 255
  const SlmSnapshot now = opened();
  EXPECT_NE(now.fault.find("5 % of the pixels differ, and level 255 is shown as 0;"),
            std::string::npos)
      << now.fault;
}

TEST_F(Opening, AnOutputThatCannotBeReadIsUsed) {
  compositor_.hides = true;
  EXPECT_TRUE(opened().healthy);
}

TEST_F(Opening, ReadBackLeavesTheDisplaysTimeToHolograms) {
  opened();
  const int presented = compositor_.presented, read = compositor_.read;
  int answers = 0;
  const auto turn = [&](std::uint64_t hologram_id) {
    loop_.verify([&](const Result<VerifyReport>&) { ++answers; });
    const auto levels = std::make_shared<const Image<std::uint8_t>>(kWidth, kHeight);
    loop_.show_when_possible({hologram_id, 3, HologramKind::sensor, levels});
    loop_.do_work();
  };
  compositor_.read_takes = std::chrono::milliseconds(20);
  for (std::uint64_t id = 1; id <= 200; ++id) turn(id);
  EXPECT_EQ(compositor_.presented, presented + 200);
  EXPECT_GT(compositor_.read, read);
  EXPECT_LT(compositor_.read, read + 100);  // once in 180 ms
  const int before = compositor_.read;
  test::skip(std::chrono::milliseconds(500));
  loop_.do_work();
  EXPECT_EQ(answers, 200) << "one read-back answers all that wait";
  EXPECT_LE(compositor_.read, before + 1);
  turn(201);
  loop_.close();
  EXPECT_EQ(answers, 201) << "none is left without an answer";
}

}  // namespace
}  // namespace ovws
