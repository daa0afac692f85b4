/// Frame validity rules, tested on both sides of every boundary.
#include "core/pipeline/frame_rules.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/time.hpp"

namespace ovws {
namespace {

using test::kMs;

constexpr std::uint64_t kEpoch = 7;

/// Hologram 4 stood from 100 ms on; at 200 ms hologram 5 was presented, settled at 230 ms.
ShownHologram changing() {
  ShownHologram shown;
  shown.healthy = true;
  shown.previous = {4, kEpoch, 80 * kMs, 100 * kMs};
  shown.current = {5, kEpoch, 200 * kMs, 230 * kMs};
  return shown;
}

void expect(const HologramVerdict& verdict, std::uint64_t id, bool settled) {
  EXPECT_EQ(verdict.hologram_id, id);
  EXPECT_EQ(verdict.settled, settled);
}

TEST(HologramRule, AnExposureThatBeginsAsTheHologramSettlesIsOfIt) {
  expect(judge_hologram(changing(), kEpoch, 230 * kMs, 240 * kMs), 5, true);
}

TEST(HologramRule, AnExposureThatBeginsANanosecondEarlierIsNotSettled) {
  expect(judge_hologram(changing(), kEpoch, 230 * kMs - 1, 240 * kMs), 5, false);
}

TEST(HologramRule, AFrameThatArrivesAsTheChangeBeginsIsOfThePreviousHologram) {
  expect(judge_hologram(changing(), kEpoch, 190 * kMs, 200 * kMs), 4, true);
}

TEST(HologramRule, AFrameThatArrivesANanosecondLaterIsNotSettled) {
  expect(judge_hologram(changing(), kEpoch, 190 * kMs, 200 * kMs + 1), 5, false);
}

TEST(HologramRule, ThePreviousHologramMustHaveSettledToo) {
  expect(judge_hologram(changing(), kEpoch, 100 * kMs, 200 * kMs), 4, true);
  expect(judge_hologram(changing(), kEpoch, 100 * kMs - 1, 200 * kMs), 5, false);
}

TEST(HologramRule, WhilePresentingNothingNewSettles) {
  ShownHologram shown = changing();
  shown.current.t_settled_mono_ns = ShownHologram::kNever;
  expect(judge_hologram(shown, kEpoch, 5000 * kMs, 5010 * kMs), 5, false);
  expect(judge_hologram(shown, kEpoch, 190 * kMs, 200 * kMs), 4, true);
}

TEST(HologramRule, AHologramOfAnotherSensorIsNamedButDoesNotCount) {
  expect(judge_hologram(changing(), kEpoch + 1, 300 * kMs, 310 * kMs), 5, false);
  expect(judge_hologram(changing(), kEpoch + 1, 190 * kMs, 200 * kMs), 4, false);
}

TEST(HologramRule, APatternThatIsNoSensorNeverCounts) {
  ShownHologram shown = changing();
  shown.current.sensor_epoch = 0;
  expect(judge_hologram(shown, 0, 300 * kMs, 310 * kMs), 5, false);
}

constexpr double kLambdaD = 12.55;

bool explained(double residual_lambda_d, float quality, float noise = 0.0F, int lost = 0) {
  std::vector<SpotFix> spots(19, SpotFix{1.0F, 1.0F, 250.0F, 0.9F, 200.0F, noise});
  spots[7].quality = quality;
  for (int i = 0; i < lost; ++i) spots[std::size_t(18 - i)] = {};
  Reconstruction found;
  found.used = 19 - lost;
  found.lost = lost;
  found.determined = true;
  found.fit_residual_px = residual_lambda_d * kLambdaD;
  return is_explained(found, spots, kLambdaD);
}

TEST(EnoughFoundRule, SpotsWithoutAReferenceDoNotCount) {
  std::vector<SpotFix> spots(19, SpotFix{1.0F, 1.0F, 250.0F, 0.9F, 200.0F, 0.0F});
  std::vector<Vec2> reference_px(19, Vec2{1.0, 1.0});
  for (std::size_t i = 0; i < 3; ++i) {
    spots[i] = {};
    reference_px[i] = {NAN, NAN};
  }
  spots[3] = {};
  EXPECT_TRUE(enough_found(spots, reference_px)) << "1 of 16";
  EXPECT_FALSE(enough_found(spots, std::vector<Vec2>(19, Vec2{1.0, 1.0}))) << "4 of 19";
  spots[4] = {};
  EXPECT_TRUE(enough_found(spots, reference_px)) << "2 of 16";
  spots[5] = {};
  EXPECT_FALSE(enough_found(spots, reference_px)) << "3 of 16";
}

TEST(ExplainedRule, WhatInterferenceLeavesIsExplainedWhateverTheSpotsLookLike) {
  EXPECT_TRUE(explained(0.04, 0.1F));
  EXPECT_TRUE(explained(0.06, 0.9F));
}

TEST(ExplainedRule, MoreIsExplainedWhileEverySpotIsWhole) {
  EXPECT_TRUE(explained(0.07, 0.66F));
  EXPECT_FALSE(explained(0.07, 0.64F));
  EXPECT_TRUE(explained(0.22, 0.9F));
  EXPECT_FALSE(explained(0.26, 0.9F));
}

TEST(ExplainedRule, LessIsExplainedWhileASpotIsLost) {
  EXPECT_TRUE(explained(0.04, 0.9F, 0.0F, 3));
  EXPECT_FALSE(explained(0.06, 0.9F, 0.0F, 1));
}

TEST(ExplainedRule, NothingIsExplainedByFewerThanFiveSixths) {
  EXPECT_TRUE(explained(0.0, 0.9F, 0.0F, 3));
  EXPECT_FALSE(explained(0.0, 0.9F, 0.0F, 4));
  EXPECT_FALSE(explained(0.0, 0.9F, 180.0F, 4));
}

TEST(ExplainedRule, NoiseMayLeaveMore) {
  EXPECT_FALSE(explained(0.09, 0.4F));
  EXPECT_TRUE(explained(0.09, 0.4F, 180.0F));  // SNR 2
  EXPECT_FALSE(explained(0.12, 0.4F, 180.0F));
  EXPECT_FALSE(explained(NAN, 0.9F));
}

TEST(HologramRule, WithAFaultyDisplayNothingIsSettled) {
  ShownHologram shown = changing();
  shown.healthy = false;
  expect(judge_hologram(shown, kEpoch, 300 * kMs, 310 * kMs), 5, false);
  expect(judge_hologram(shown, kEpoch, 190 * kMs, 200 * kMs), 5, false);
}

/// From 1 ms and 0 dB to 4 ms and 6 dB, written from 500 to 503 ms; transfer takes at most 2 ms.
AppliedSettings changed() {
  AppliedSettings settings;
  settings.gain_db = 6.0;
  settings.exposure_us = 4000.0;
  settings.previous_gain_db = 0.0;
  settings.gain_raw = 7.0;
  settings.previous_gain_raw = 2.0;
  settings.previous_exposure_us = 1000.0;
  settings.t_write_begin_mono_ns = 500 * kMs;
  settings.t_write_end_mono_ns = 503 * kMs;
  settings.transfer_ns = 2 * kMs;
  return settings;
}

TEST(SettingsRule, AnExposureThatBeginsAsTheWriteEndsHasTheNewValues) {
  const SettingsVerdict verdict = judge_settings(changed(), 509 * kMs);  // 509 - 4 - 2 = 503
  EXPECT_TRUE(verdict.known);
  EXPECT_EQ(verdict.gain_db, 6.0);
  EXPECT_EQ(verdict.gain_raw, 7.0);
  EXPECT_EQ(verdict.exposure_us, 4000.0);
  EXPECT_EQ(verdict.exposure_begin_mono_ns, 503 * kMs);
}

TEST(SettingsRule, AnExposureThatBeginsANanosecondEarlierIsUnknown) {
  const SettingsVerdict verdict = judge_settings(changed(), 509 * kMs - 1);
  EXPECT_FALSE(verdict.known);
  EXPECT_EQ(verdict.exposure_begin_mono_ns, 503 * kMs - 1);
}

TEST(SettingsRule, AFrameThatArrivesAsTheWriteBeginsHasThePreviousValues) {
  const SettingsVerdict verdict = judge_settings(changed(), 500 * kMs);
  EXPECT_TRUE(verdict.known);
  EXPECT_EQ(verdict.gain_db, 0.0);
  EXPECT_EQ(verdict.gain_raw, 2.0);
  EXPECT_EQ(verdict.exposure_us, 1000.0);
  EXPECT_EQ(verdict.exposure_begin_mono_ns, 497 * kMs);
}

TEST(SettingsRule, ThePreviousValuesMustHaveBeenWrittenBeforeTheExposureToo) {
  AppliedSettings settings = changed();
  settings.t_previous_end_mono_ns = 497 * kMs;  // 500 - 1 - 2
  EXPECT_TRUE(judge_settings(settings, 500 * kMs).known);
  EXPECT_FALSE(judge_settings(settings, 500 * kMs - 1).known);
}

TEST(SettingsRule, AFrameThatArrivesANanosecondLaterIsUnknown) {
  EXPECT_FALSE(judge_settings(changed(), 500 * kMs + 1).known);
}

TEST(SettingsRule, AfterALongExposureAFrameMayStillBeOfItAndIsUnknown) {
  AppliedSettings settings = changed();
  settings.exposure_us = 1000.0;
  settings.previous_exposure_us = 100'000.0;
  // One of 1 ms would have begun after the write; one of 100 ms would not.
  EXPECT_FALSE(judge_settings(settings, 520 * kMs).known);
  const SettingsVerdict later = judge_settings(settings, 605 * kMs);
  EXPECT_TRUE(later.known);
  EXPECT_EQ(later.exposure_begin_mono_ns, 602 * kMs);
}

TEST(SettingsRule, WhileTheDeviceIsWrittenNothingIsKnownOfNewFrames) {
  AppliedSettings settings = changed();
  settings.t_write_end_mono_ns = ShownHologram::kNever;
  EXPECT_FALSE(judge_settings(settings, 5000 * kMs).known);
  EXPECT_TRUE(judge_settings(settings, 499 * kMs).known);
}

TEST(SettingsRule, BeforeAnythingWasAppliedNothingIsKnown) {
  EXPECT_FALSE(judge_settings({}, 500 * kMs).known);
}

/// Nine spots in a square of 40 px about (x, 0).
std::vector<SpotFix> square_at(float x) {
  std::vector<SpotFix> spots;
  for (int k = 0; k < 9; ++k) {
    SpotFix spot;
    spot.x = x + float(20 * (k % 3 - 1));
    spot.y = float(20 * (k / 3 - 1));
    spots.push_back(spot);
  }
  return spots;
}

TEST(ApartRule, TheSpotsOfTwoSourcesNeedTwoLambdaD) {
  const auto main = square_at(0.0F);
  const double both = 2.0 * std::sqrt(800.0);  // the radii
  EXPECT_TRUE(are_apart(main, square_at(float(both + 20.1)), 10.0));
  EXPECT_FALSE(are_apart(main, square_at(float(both + 19.9)), 10.0));
  EXPECT_FALSE(are_apart(main, main, 10.0));
}

TEST(ApartRule, ASourceOfWhichLittleIsFoundIsNotNear) {
  auto dim = square_at(60.0F);
  for (int k = 0; k < 4; ++k) dim[std::size_t(k)] = SpotFix();
  EXPECT_FALSE(are_apart(square_at(0.0F), dim, 10.0));
  dim[4] = SpotFix();
  EXPECT_TRUE(are_apart(square_at(0.0F), dim, 10.0));
  EXPECT_TRUE(are_apart(square_at(0.0F), {}, 10.0));
}

}  // namespace
}  // namespace ovws
