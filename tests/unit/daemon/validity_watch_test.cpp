/// The reason why no frame is valid, tested with injected time.
#include "daemon/ovwsd/sensor/validity_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/pipeline/frame_rules.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kS = 1'000'000'000;

constexpr std::int64_t kUtcNs = 1000 * kS;

Lack lost(int tracked) {
  return {.verdict = Verdict::spots_lost, .tracked = tracked, .spots = 19, .searched = true};
}

class ValidityWatchTest : public testing::Test {
 protected:
  /// Why frames like `newest`, noted at 2 s, are not valid at 3 s.
  StatusMessage::SensorPart::Invalid why(const Lack& newest, std::size_t source = 0) {
    watch_.note(source, {}, kS);
    watch_.note(source, newest, 2 * kS);
    const auto why = watch_.why_invalid(source, 3 * kS, kUtcNs);
    EXPECT_TRUE(why);
    return why.value_or(StatusMessage::SensorPart::Invalid{});
  }
  ImageBrightness brightness_;
  ValidityWatch watch_{std::vector<BeamConfig>{{"red", {}}}, brightness_};
};

TEST_F(ValidityWatchTest, CountsFromTheFirstInvalidFrame) {
  EXPECT_FALSE(watch_.lack(0, kS));
  watch_.note(0, {}, kS);
  EXPECT_FALSE(watch_.lack(0, kS));
  watch_.note(0, lost(7), 2 * kS);
  watch_.note(0, lost(5), 3 * kS);
  const auto lack = watch_.lack(0, 3 * kS);
  ASSERT_TRUE(lack);
  EXPECT_EQ(lack->since_ns, 2 * kS);
  EXPECT_EQ(lack->tracked, 5);
  EXPECT_FALSE(watch_.is_valid(0));
  EXPECT_TRUE(watch_.is_valid(1)) << "each source has its own";
  watch_.note(0, {}, 4 * kS);
  EXPECT_FALSE(watch_.lack(0, 4 * kS));
  EXPECT_TRUE(watch_.is_valid(0));
}

TEST_F(ValidityWatchTest, SaysNothingWhenNoFramesCome) {
  watch_.note(0, lost(7), kS);
  EXPECT_TRUE(watch_.lack(0, 2 * kS));
  EXPECT_FALSE(watch_.lack(0, 3 * kS));
  EXPECT_FALSE(watch_.is_valid(0));
}

TEST_F(ValidityWatchTest, ReportsTheFactsOfOneFrameTogether) {
  std::atomic<bool> ended{false};
  std::thread frames([&] {
    for (int k = 1; k <= 2'000'000; ++k) {
      const double at = k;
      watch_.note(0,
                  {.verdict = k % 2 == 0 ? Verdict::spots_lost : Verdict::unexplained,
                   .tracked = k,
                   .spots = k,
                   .branch_points = k,
                   .branch_point = {{at, at}, k}},
                  kS);
    }
    ended = true;
  });
  int torn = 0;
  while (!ended) {
    const auto lack = watch_.lack(0, kS);
    if (!lack) continue;  // before the first frame
    const int k = lack->tracked;
    const bool whole = lack->spots == k && (lack->verdict == Verdict::spots_lost) == (k % 2 == 0) &&
                       lack->branch_points == k &&
                       lack->branch_point.at == Vec2{double(k), double(k)} &&
                       lack->branch_point.charge == k;
    torn += whole ? 0 : 1;
  }
  frames.join();
  EXPECT_EQ(torn, 0);
}

TEST_F(ValidityWatchTest, SaysWhyWhatIsDoneAndWhen) {
  for (int k = 0; k < 3; ++k) watch_.search_failed(4 * kS);
  Lack lack = lost(19);
  lack.verdict = Verdict::unexplained;
  const auto waiting = why(lack);
  EXPECT_EQ(waiting.t_since_ns, kUtcNs - kS);
  EXPECT_EQ(waiting.reason, "19 of 19 spots are found, but no wavefront explains their positions");
  EXPECT_EQ(waiting.action,
            "the image's wavefront was searched 3 times; again in 1.0 s, or at once when the image "
            "changes");
  EXPECT_EQ(waiting.t_next_search_ns, kUtcNs + kS);
  lack.verdict = Verdict::unconfirmed;
  const auto waits = why(lack);
  EXPECT_EQ(waits.reason, "19 of 19 spots are found, but templates have not confirmed them yet");
  EXPECT_EQ(waits.action, "wait: templates of this wavefront are being rendered");
  EXPECT_FALSE(waits.t_next_search_ns);
  watch_.search_begins();
  const auto running = why(lost(7));
  EXPECT_EQ(running.reason, "7 of 19 spots are found");
  EXPECT_EQ(running.action, "the image's wavefront is being searched");
  EXPECT_FALSE(running.t_next_search_ns);
  lack = lost(7);
  lack.searched = false;
  const auto plain = why(lack);
  EXPECT_EQ(plain.action, "use the tracker fit: it also finds strong aberrations");
  EXPECT_FALSE(plain.t_next_search_ns);
}

TEST_F(ValidityWatchTest, SaysWhatNoSearchHelps) {
  const std::string other = "the source red";
  Lack lack{.verdict = Verdict::no_pattern, .spots = 19};
  EXPECT_EQ(why(lack).reason, "the frame's pattern is not certain");
  EXPECT_NE(why(lack).action.find("dmd.slots"), std::string::npos);
  lack.tracked = 18;
  lack.verdict = Verdict::undetermined;
  EXPECT_EQ(why(lack).reason, "18 of 19 spots are found, which do not determine all modes");
  EXPECT_NE(why(lack).action.find("mode_count"), std::string::npos);
  lack.verdict = Verdict::too_close;
  lack.other = &other;
  EXPECT_EQ(in_words(why(lack)),
            "18 of 19 spots are found, but too close to those of the source red; tilt the light "
            "sources apart");
}

TEST_F(ValidityWatchTest, ADarkImageIsTheReason) {
  Lack lack = lost(0);
  lack.searched = false;
  EXPECT_TRUE(why(lack).action.starts_with("use the tracker fit"));
  Image<std::uint8_t> image(64, 48);
  brightness_.look(view_of(image), 2 * kS);
  EXPECT_TRUE(why(lack).action.starts_with("the image is dark, its brightest pixels reach 0.0 %"));
  EXPECT_EQ(why(lack, 1).action, "check the light of this source");
  std::fill_n(image.pixels.begin() + 100, 16, std::uint8_t(128));
  brightness_.look(view_of(image), 2 * kS);
  EXPECT_TRUE(why(lack).action.starts_with("use the tracker fit"));
}

TEST_F(ValidityWatchTest, TooBrightLightIsTheReasonIfSpotsAreLost) {
  for (const bool searched : {false, true}) {
    const auto action = [&](int tracked, double saturated) {
      Lack lack = lost(tracked);
      lack.searched = searched;
      lack.enough_found = tracked > 15;
      lack.saturated = saturated;
      return why(lack).action;
    };
    const std::string bright =
        "too bright, 100 % of the spots are saturated: lower the exposure or the gain";
    EXPECT_EQ(action(0, 1.0), bright);
    EXPECT_NE(action(18, 1.0), bright) << "the spots are found";
    EXPECT_EQ(action(0, 1.0 / 19.0), action(0, 0.0)) << "a hot pixel";
  }
}

/// A settled frame with a reference of two sources' spots.
class VerdictTest : public ValidityWatchTest {
 protected:
  VerdictTest() {
    plan_.reference_px = at(100.0F);
    plan_.predicted_px = plan_.reference_px;
    plan_.spots.lambda_d_px = 10.0;
    record_.plan = &plan_;
    record_.still = record_.settled = record_.explained = true;
    record_.reconstruction.determined = true;
    record_.branch_points = {};
    find(record_, 100.0F);
  }
  static std::vector<Vec2> at(float left) {
    std::vector<Vec2> all;
    for (int k = 0; k < 9; ++k) all.push_back({double(left) + 40.0 * (k % 3), 40.0 * (k / 3)});
    return all;
  }
  static void find(FrameRecord& record, float left) {
    record.spots.clear();
    for (const Vec2 spot : at(left)) record.spots.push_back({float(spot.x), float(spot.y)});
    record.spot_count = record.tracked = int(record.spots.size());
  }
  Verdict verdict() const { return verdict_of(record_); }
  MeasurementPlan plan_;
  FrameRecord record_;
};

TEST_F(VerdictTest, IsTheFirstReasonThatApplies) {
  EXPECT_EQ(verdict(), Verdict::spots_lost) << "whatever else is wrong";
  record_.explained = false;
  EXPECT_EQ(verdict(), Verdict::unexplained);
  record_.unconfirmed = true;
  EXPECT_EQ(verdict(), Verdict::unconfirmed);
  record_.branch_points.count = 1;
  EXPECT_EQ(verdict(), Verdict::branch_points);
  record_.reconstruction.determined = false;
  EXPECT_EQ(verdict(), Verdict::undetermined);
  EXPECT_EQ(verdict_of(record_, true), Verdict::too_close);
  plan_.reference_px.clear();
  EXPECT_EQ(verdict(), Verdict::no_reference);
  record_.settled = false;
  EXPECT_EQ(verdict(), Verdict::other_hologram);
  plan_.patterns.push_back(nullptr);
  EXPECT_EQ(verdict(), Verdict::no_pattern);
  record_.still = false;
  EXPECT_EQ(verdict(), Verdict::changing);
  record_.late = true;
  EXPECT_EQ(verdict(), Verdict::late);
  record_.valid = true;
  EXPECT_EQ(verdict(), Verdict::valid);
}

TEST_F(VerdictTest, OfFewSpotsIsThatTheyAreLost) {
  record_.explained = false;
  for (int k = 0; k < 4; ++k) record_.spots[std::size_t(k)] = {NAN, NAN};
  EXPECT_EQ(verdict(), Verdict::spots_lost);
}

TEST_F(VerdictTest, NamesTheSourceThatIsTooClose) {
  FrameRecord beam = record_;
  plan_.beams.push_back(std::make_shared<const MeasurementPlan>(plan_));
  beam.plan = plan_.beams.front().get();
  record_.beam_records = {&beam};
  find(beam, 190.0F);
  record_.verdict = beam.verdict = Verdict::too_close;
  watch_.on_frame(record_, true, kS);
  EXPECT_EQ(*watch_.lack(0, kS)->other, "the source red");
  EXPECT_EQ(*watch_.lack(1, kS)->other, "the main source");
}

TEST_F(VerdictTest, OfASequenceIsGivenAfterThreeCycles) {
  plan_.patterns.push_back(std::make_shared<const MeasurementPlan>());
  plan_.cycle.slots = 2;
  record_.settled = false;
  record_.still = true;
  for (int k = 0; k < 6; ++k) {
    EXPECT_TRUE(watch_.is_valid(0)) << k;
    watch_.on_frame(record_, false, kS);
  }
  EXPECT_EQ(watch_.lack(0, kS)->verdict, Verdict::no_pattern);
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
