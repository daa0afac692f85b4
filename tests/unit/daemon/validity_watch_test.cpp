/// The reason why no frame is valid, tested with injected time.
#include "daemon/ovwsd/sensor/validity_watch.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace ovws {
namespace {

constexpr std::int64_t kS = 1'000'000'000;

TEST(ValidityWatch, CountsFromTheFirstInvalidFrame) {
  const ImageBrightness unknown;
  ValidityWatch watch(unknown);
  EXPECT_FALSE(watch.lack(kS));
  watch.on_frame(true, {0, 19, 19, true}, kS);
  EXPECT_FALSE(watch.lack(kS));
  watch.on_frame(false, {0, 7, 19, true}, 2 * kS);
  watch.on_frame(false, {0, 5, 19, true}, 3 * kS);
  const auto lack = watch.lack(3 * kS);
  ASSERT_TRUE(lack);
  EXPECT_EQ(lack->since_ns, 2 * kS);
  EXPECT_EQ(lack->tracked, 5);
  EXPECT_FALSE(watch.is_valid());
  watch.on_frame(true, {0, 19, 19, true}, 4 * kS);
  EXPECT_FALSE(watch.lack(4 * kS));
  EXPECT_TRUE(watch.is_valid());
}

TEST(ValidityWatch, SaysNothingWhenNoFramesCome) {
  const ImageBrightness unknown;
  ValidityWatch watch(unknown);
  watch.on_frame(false, {0, 7, 19, true}, kS);
  EXPECT_TRUE(watch.lack(2 * kS));
  EXPECT_FALSE(watch.lack(3 * kS));
  EXPECT_FALSE(watch.is_valid());
}

TEST(ValidityWatch, ReportsTheFactsOfOneFrameTogether) {
  const ImageBrightness unknown;
  ValidityWatch watch(unknown);
  std::atomic<bool> ended{false};
  std::thread frames([&] {
    for (int k = 1; k <= 2'000'000; ++k) {
      const double at = k;
      watch.on_frame(false,
                     {.tracked = k,
                      .spots = k,
                      .explained = k % 2 == 0,
                      .branch_points = k,
                      .branch_point = {{at, at}, k}},
                     kS);
    }
    ended = true;
  });
  int torn = 0;
  while (!ended) {
    const auto lack = watch.lack(kS);
    if (!lack) continue;  // before the first frame
    const int k = lack->tracked;
    const bool whole =
        lack->spots == k && lack->explained == (k % 2 == 0) && lack->branch_points == k &&
        lack->branch_point.at == Vec2{double(k), double(k)} && lack->branch_point.charge == k;
    torn += whole ? 0 : 1;
  }
  frames.join();
  EXPECT_EQ(torn, 0);
}

TEST(ValidityWatch, SaysWhyWhatIsDoneAndWhen) {
  const std::int64_t utc_ns = 1000 * kS;
  const ValidityWatch::Lack lack{2 * kS, 19, 19, false};
  const auto waiting = invalid_in_words(lack, {false, 3, 5 * kS}, 4 * kS, utc_ns);
  EXPECT_EQ(waiting.t_since_ns, 998 * kS);
  EXPECT_EQ(waiting.reason, "19 of 19 spots are found, but no wavefront explains their positions");
  EXPECT_EQ(waiting.action,
            "the image's wavefront was searched 3 times; again in 1.0 s, or at once when the image "
            "changes");
  EXPECT_EQ(waiting.t_next_search_ns, 1001 * kS);
  const auto running = invalid_in_words({2 * kS, 7, 19, true}, {true, 3, 5 * kS}, 4 * kS, utc_ns);
  EXPECT_EQ(running.reason, "7 of 19 spots are found");
  EXPECT_EQ(running.action, "the image's wavefront is being searched");
  EXPECT_FALSE(running.t_next_search_ns);
  const ValidityWatch::Lack too_few{
      .since_ns = 2 * kS, .tracked = 13, .spots = 19, .explained = false, .enough_found = false};
  const auto few = invalid_in_words(too_few, {true, 3, 5 * kS}, 4 * kS, utc_ns);
  EXPECT_EQ(few.reason, "13 of 19 spots are found");
  const auto left_out = invalid_in_words({2 * kS, 15, 19, false}, {}, 4 * kS, utc_ns);
  EXPECT_EQ(left_out.reason, "15 of 19 spots are found, but no wavefront explains their positions")
      << "the reference leaves out three";
  const auto waits = invalid_in_words({2 * kS, 18, 19, false, true}, {}, 4 * kS, utc_ns);
  EXPECT_EQ(waits.reason, "18 of 19 spots are found, but templates have not confirmed them yet");
  EXPECT_EQ(waits.action, "wait: templates of this wavefront are being rendered");
  EXPECT_FALSE(waits.t_next_search_ns);
  const auto plain = invalid_in_words({2 * kS, 7, 19, true, false, false}, {}, 4 * kS, utc_ns);
  EXPECT_EQ(plain.action, "use the tracker fit: it also finds strong aberrations");
  EXPECT_FALSE(plain.t_next_search_ns);
}

TEST(ValidityWatch, SaysThatNoPatternIsCertain) {
  const ValidityWatch::Lack lack{
      .since_ns = 2 * kS, .spots = 19, .brightest = 0.0, .no_pattern = true};
  const auto said = invalid_in_words(lack, {}, 3 * kS, 100 * kS);
  EXPECT_EQ(said.reason, "no frame's pattern is certain");
  EXPECT_NE(said.action.find("dmd.slots"), std::string::npos);
}

TEST(ValidityWatch, SaysThatNearlyAllSpotsDoNotDetermineTheModes) {
  const ImageBrightness unknown;
  ValidityWatch watch(unknown);
  watch.on_frame(false, {.tracked = 796, .spots = 797, .undetermined = true}, 2 * kS);
  EXPECT_EQ(watch.why_invalid(3 * kS, 100 * kS)->reason, "796 of 797 spots are found");
  watch.on_frame(false, {.tracked = 796, .spots = 797, .searched = false, .undetermined = true},
                 2 * kS);
  const auto said = watch.why_invalid(3 * kS, 100 * kS);
  ASSERT_TRUE(said);
  EXPECT_EQ(said->reason, "796 of 797 spots are found, which do not determine all modes");
  EXPECT_NE(said->action.find("mode_count"), std::string::npos) << said->action;
}

TEST(ValidityWatch, SaysThatTwoSourcesAreTooClose) {
  const ImageBrightness unknown;
  ValidityWatch watch(unknown);
  watch.on_frame(
      false,
      {.tracked = 19, .spots = 19, .explained = false, .branch_points = 1, .too_close = true},
      2 * kS);
  const auto said = watch.why_invalid(3 * kS, 100 * kS);
  ASSERT_TRUE(said);
  EXPECT_EQ(said->reason, "19 of 19 spots are found, but too close to another source's");
  EXPECT_NE(said->action.find("tilt the light sources apart"), std::string::npos) << said->action;
}

TEST(ValidityWatch, ADarkImageIsTheReason) {
  ImageBrightness brightness;
  ValidityWatch watch(brightness);
  watch.on_frame(false, {0, 0, 19, true, false, false}, 2 * kS);
  const auto why = [&] { return watch.why_invalid(2 * kS, 0)->action; };
  EXPECT_TRUE(why().starts_with("use the tracker fit"));
  Image<std::uint8_t> image(64, 48);
  brightness.look(view_of(image), 2 * kS);
  EXPECT_TRUE(why().starts_with("the image is dark, its brightest pixels reach 0.0 % of")) << why();
  std::fill_n(image.pixels.begin() + 100, 16, std::uint8_t(128));
  brightness.look(view_of(image), 2 * kS);
  EXPECT_TRUE(why().starts_with("use the tracker fit"));
}

TEST(ValidityWatch, TooBrightLightIsTheReasonIfSpotsAreLost) {
  for (const bool searched : {false, true}) {
    const auto why = [&](int tracked, double saturated) {
      const ValidityWatch::Lack lack{.since_ns = 2 * kS,
                                     .tracked = tracked,
                                     .spots = 81,
                                     .searched = searched,
                                     .brightest = 1.0,
                                     .enough_found = tracked > 67,
                                     .saturated = saturated};
      return invalid_in_words(lack, {false, 3, 5 * kS}, 4 * kS, 0).action;
    };
    const std::string bright =
        "too bright, 100 % of the spots are saturated: lower the exposure or the gain";
    EXPECT_EQ(why(0, 1.0), bright);
    EXPECT_NE(why(80, 1.0), bright) << "the spots are found";
    EXPECT_EQ(why(0, 1.0 / 81.0), why(0, 0.0)) << "a hot pixel";
  }
}

TEST(ImageBrightness, IsThatOfThe16BrightestPixelsForThreeSeconds) {
  ImageBrightness brightness;
  EXPECT_FALSE(brightness.newest(0));
  Image<std::uint8_t> image(64, 48);
  std::fill_n(image.pixels.begin() + 500, 15, std::uint8_t(255));  // hot pixels
  image.pixels[0] = 51;
  brightness.look(view_of(image), kS);
  EXPECT_NEAR(brightness.newest(4 * kS).value(), 0.2, 1e-3);
  EXPECT_FALSE(brightness.newest(4 * kS + 1));
  image.pixels[1] = 255;
  brightness.look(view_of(image), kS);
  EXPECT_EQ(brightness.newest(kS), 1.0);
}

}  // namespace
}  // namespace ovws
