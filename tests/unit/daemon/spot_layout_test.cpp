/// Benches whose camera can and cannot see the spots; values that a refusal recommends must work.
#include "daemon/ovwsd/layout/spot_layout.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "config/config.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"

namespace ovws {
namespace {

Config bench_of(int charge, TrackerKind tracker, int across = 5, double spacing = 0.25) {
  Config config;
  config.sensor.charge = charge;
  config.sensor.subapertures_across = across;
  config.sensor.spacing = spacing;
  config.tracking.tracker = tracker;
  return config;
}

/// The refusal's field and reason; empty if it is accepted.
std::string layout_refusal(const Config& config) {
  const auto seen = check_sees_spots(config);
  return seen ? "" : seen.error().field + ": " + seen.error().reason;
}

/// The number after `words` in the text.
double number_after(const std::string& text, const std::string& words) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(words + " ([0-9.]+)")) ? std::stod(found[1])
                                                                          : 0.0;
}
Roi region_named(const std::string& text) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex("at least (\\d+) x (\\d+) px"))) return {};
  return {0, 0, std::stoi(found[1]), std::stoi(found[2])};
}

TEST(SpotLayout, BenchesThatWereMeasuredToWorkAreAccepted) {
  EXPECT_EQ(layout_refusal(Config{}), "");
  EXPECT_EQ(layout_refusal(bench_of(0, TrackerKind::fit)), "");
  EXPECT_EQ(layout_refusal(bench_of(-1, TrackerKind::fit)), "");
  EXPECT_EQ(layout_refusal(bench_of(2, TrackerKind::fit)), "");
  EXPECT_EQ(layout_refusal(bench_of(3, TrackerKind::lg)), "");
  EXPECT_EQ(layout_refusal(bench_of(0, TrackerKind::thresholded, 7)), "");
  EXPECT_EQ(layout_refusal(bench_of(1, TrackerKind::lg, 7)), "");
  EXPECT_EQ(layout_refusal(bench_of(1, TrackerKind::lg, 4)), "");
}

Config lenslets(double focal_length_mm, double pupil_mm, int roi_px) {
  auto config = parse_config(R"({"modulator": "fixed", "sensor": {"charge": 0, "grid": "square"},
                                 "tracking": {"tracker": "lg"},
                                 "optics": {"camera_pitch_um": 5.3, "focal_length_mm": )" +
                             std::to_string(focal_length_mm) +
                             "}, \"array\": {\"pupil_mm\": " + std::to_string(pupil_mm) + "}}")
                    .value();
  config.camera.settings.roi = {0, 0, roi_px, roi_px};
  return config;
}

TEST(SpotLayout, ARefusalOfLensletsNamesTheirKeysWithValuesThatWork) {
  EXPECT_EQ(layout_refusal(lenslets(10.0, 5.0, 1024)), "");
  const std::string near = layout_refusal(lenslets(50.0, 5.0, 1024));
  EXPECT_TRUE(near.starts_with("optics.focal_length_mm: neighbouring spots are ")) << near;
  EXPECT_EQ(layout_refusal(lenslets(number_after(near, "at most"), 5.0, 1024)), "");
  const std::string outside = layout_refusal(lenslets(10.0, 5.0, 512));
  EXPECT_TRUE(outside.starts_with("camera.roi: ")) << outside;
  EXPECT_EQ(layout_refusal(lenslets(10.0, number_after(outside, "array.pupil_mm to"), 512)), "");
}

TEST(SpotLayout, SpotsThatATrackerCannotSeparateAreRefusedWithValuesThatWork) {
  Config large_slm;
  large_slm.slm.geometry = {3840, 2160, 3.74};
  for (Config config :
       {bench_of(1, TrackerKind::lg, 9), bench_of(7, TrackerKind::lg), large_slm,
        bench_of(2, TrackerKind::lg, 7), bench_of(3, TrackerKind::lg, 7, 0.31),
        bench_of(3, TrackerKind::lg, 5, 0.16), bench_of(0, TrackerKind::centroid, 5, 0.09)}) {
    const std::string reason = layout_refusal(config);
    SCOPED_TRACE(reason);
    ASSERT_TRUE(reason.starts_with("sensor.spacing: neighbouring spots are "));
    EXPECT_NE(reason.find(" to "), std::string::npos);
    if (const double fewer = number_after(reason, "sensor.subapertures_across to"); fewer > 0) {
      Config other = config;
      other.sensor.subapertures_across = int(fewer);
      EXPECT_FALSE(layout_refusal(other).starts_with("sensor.spacing")) << layout_refusal(other);
    }
    const double spacing = number_after(reason, "sensor.spacing to");
    if (spacing == 0.0) continue;  // its region would contain the zeroth order
    config.sensor.spacing = spacing;
    if (reason.find("camera.roi") != std::string::npos) {
      EXPECT_TRUE(layout_refusal(config).empty() ||
                  layout_refusal(config).starts_with("camera.roi"));
      config.camera.settings.roi = region_named(reason);
    }
    EXPECT_EQ(layout_refusal(config), "");
  }
}

TEST(SpotLayout, SpotsOutsideTheRegionAreRefusedWithValuesThatWork) {
  Config long_lens;
  long_lens.slm.geometry = {1920, 1080, 8.0};
  long_lens.optics.focal_length_mm = 1000.0;
  Config small_region;
  small_region.camera.settings.roi = {0, 0, 512, 192};
  for (const Config& config : {long_lens, small_region}) {
    const std::string reason = layout_refusal(config);
    SCOPED_TRACE(reason);
    ASSERT_TRUE(reason.starts_with("camera.roi: "));
    Config larger = config;
    larger.camera.settings.roi = region_named(reason);
    EXPECT_EQ(layout_refusal(larger), "");
    Config other = config;
    if (const double closer = number_after(reason, "sensor.spacing to"); closer > 0.0) {
      other.sensor.spacing = closer;
    } else {
      other.optics.focal_length_mm = number_after(reason, "optics.focal_length_mm to");
    }
    EXPECT_EQ(layout_refusal(other), "");
  }
}

TEST(SpotLayout, AFewSpotsOutsideAreNoFaultIfTheOthersDetermineTheModes) {
  Config config;
  config.camera.settings.roi.width = 240;  // the middle row's ends touch the edge
  EXPECT_EQ(layout_refusal(config), "");
  config.optics.centre_px = Vec2{20.0, 20.0};
  EXPECT_TRUE(layout_refusal(config).starts_with("camera.roi: ")) << layout_refusal(config);
  EXPECT_NE(layout_refusal(config).find("optics.centre_px"), std::string::npos);
}

Config with_modes(int charge, int mode_count, int estimates = 8) {
  Config config = bench_of(charge, TrackerKind::fit);
  config.tracking.mode_count = mode_count;
  config.tracking.estimates = estimates;
  return config;
}

TEST(SpotLayout, AsManyModesAsTheSpotsDetermineAreAccepted) {
  for (const Config& config :
       {with_modes(1, 18), with_modes(1, 44), with_modes(2, 44), with_modes(0, 20)}) {
    EXPECT_EQ(layout_refusal(config), "");
  }
}

TEST(SpotLayout, MoreModesThanTheSpotsDetermineAreRefusedWithTheNumberThatIsPossible) {
  for (Config config :
       {with_modes(1, 65), with_modes(0, 44), with_modes(1, 44, 2), with_modes(1, 230)}) {
    const std::string reason = layout_refusal(config);
    SCOPED_TRACE(reason);
    ASSERT_TRUE(reason.starts_with("tracking.mode_count: 19 "));
    const int possible = int(number_after(reason, "each determine"));
    ASSERT_GE(possible, 18);
    EXPECT_GT(number_after(reason, "error together is"), 0.0);
    config.tracking.mode_count = possible;
    EXPECT_EQ(layout_refusal(config), "");
    config.tracking.mode_count = possible + 1;
    EXPECT_NE(layout_refusal(config), "");
  }
}

TEST(SpotLayout, ModesThatOnlyShapesDetermineNeedTheTrackerFit) {
  Config config = with_modes(1, 44);
  config.tracking.tracker = TrackerKind::lg;
  EXPECT_TRUE(layout_refusal(config).starts_with("tracking.mode_count: positions"))
      << layout_refusal(config);
  EXPECT_NE(layout_refusal(with_modes(1, 9)), "");
}

TEST(SpotLayout, TheZerothOrderInTheRegionIsToldWithGroovesThatMoveItOut) {
  Config config = bench_of(1, TrackerKind::lg);
  EXPECT_TRUE(check_zeroth_order(config));
  config.sensor.grooves = {100.0, 20.0};  // the zeroth order is 151 px to the left of the spots
  const auto refused = check_zeroth_order(config);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera.roi");
  config.sensor.grooves[0] = number_after(refused.error().reason, "sensor.grooves to");
  EXPECT_TRUE(check_zeroth_order(config)) << refused.error().reason;
}

}  // namespace
}  // namespace ovws
