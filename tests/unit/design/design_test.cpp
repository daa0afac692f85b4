/// Designs of benches: what is accepted can be measured, what is refused names a change that helps.
#include "daemon/ovws/design/design.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>

#include "config/devices.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovws/design/advise.hpp"
#include "daemon/ovws/design/search.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"

namespace ovws::design {
namespace {

std::string text_of(const Bench& bench) {
  return "SLM " + std::to_string(bench.slm.width_px) + "x" + std::to_string(bench.slm.height_px) +
         "@" + std::to_string(bench.slm.pitch_um) + ", camera " +
         std::to_string(bench.sensor_width) + "x" + std::to_string(bench.sensor_height) + "@" +
         std::to_string(bench.camera_pitch_um) + ", f " + std::to_string(bench.focal_length_mm) +
         " mm, " + std::to_string(bench.wavelength_nm) + " nm, x" +
         std::to_string(bench.magnification) + ", beam " +
         std::to_string(bench.beam_mm.value_or(0.0)) + " mm, modes " +
         std::to_string(bench.modes.value_or(0)) + ", charge " + std::to_string(bench.charge);
}

/// Draws a plausible or nearly plausible bench.
class RandomBench {
 public:
  explicit RandomBench(unsigned seed) : engine_(seed) {}

  Bench operator()() {
    const Devices& known = known_devices();
    Bench bench;
    const SlmModel& slm = known.slms[index(known.slms.size())];
    const CameraModel& camera = known.cameras[index(known.cameras.size())];
    bench.slm = slm.geometry;
    bench.settle_ms = slm.settle_ms;
    bench.sensor_width = camera.width;
    bench.sensor_height = camera.height;
    bench.camera_pitch_um = camera.pitch_um;
    bench.wavelength_nm = logarithmic(400.0, 1100.0);
    bench.focal_length_mm = logarithmic(30.0, 1000.0);
    if (index(3) == 0) bench.magnification = logarithmic(0.2, 10.0);
    if (index(2) == 0) bench.beam_mm = logarithmic(1.0, 20.0);
    if (index(2) == 0) bench.modes = 1 + int(index(40));
    bench.charge = int(index(4)) == 0 ? 0 : 1;
    return bench;
  }

 private:
  std::size_t index(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_);
  }
  double logarithmic(double from, double to) {
    return std::exp(std::uniform_real_distribution(std::log(from), std::log(to))(engine_));
  }

  std::mt19937 engine_;
};

void expect_measurable(const Bench& bench, const Design& made) {
  const Config& config = made.config;
  EXPECT_TRUE(check_sensor(config));
  EXPECT_TRUE(check_sees_spots(config));
  const auto parsed = parse_config(dump_config(config));
  ASSERT_TRUE(parsed) << parsed.error().field << parsed.error().reason;
  EXPECT_EQ(dump_config(*parsed), dump_config(config));

  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  ASSERT_TRUE(lattice);
  const Roi& roi = config.camera.settings.roi;
  const SpotBench spots = spot_bench(config, *lattice);
  const SpotLayout layout = spot_layout(spots);
  for (const Vec2 at : layout.spots_px) {
    EXPECT_GE(std::min(at.x, at.y), layout.margin_px - 1.0);
    EXPECT_LE(at.x, roi.width - layout.margin_px);
    EXPECT_LE(at.y, roi.height - layout.margin_px);
  }
  EXPECT_GE(layout.nearest, 0.99 * recommended_spot_distance(bench.charge));
  EXPECT_TRUE(check_zeroth_order(spots));
  EXPECT_LE(roi.x + roi.width, bench.sensor_width);
  EXPECT_LE(roi.y + roi.height, bench.sensor_height);
  EXPECT_GE(made.figures.modes, bench.modes.value_or(1));
  EXPECT_GE(made.figures.finest_period_px, 2.0);
  EXPECT_GT(made.figures.range_waves, 0.25);
  EXPECT_LE(made.figures.pupil_mm, bench.beam_mm.value_or(1e3));
}

TEST(Design, RandomBenchesAreMeasurableOrRefusedWithChangesThatHelp) {
  RandomBench draw(21);
  int accepted = 0, refused = 0;
  for (int k = 0; k < 30; ++k) {
    const Bench bench = draw();
    SCOPED_TRACE(text_of(bench));
    const auto made = design(bench);
    if (made) {
      ++accepted;
      EXPECT_TRUE(check_usable(made->config));
      expect_measurable(bench, *made);
      continue;
    }
    ++refused;
    EXPECT_FALSE(made.error().finding.reason.empty());
    ASSERT_FALSE(made.error().changes.empty()) << made.error().finding.reason;
    for (const Change& change : made.error().changes) {
      SCOPED_TRACE(change.options);
      const auto changed = design(change.bench);
      ASSERT_TRUE(changed) << changed.error().finding.reason;
      expect_measurable(change.bench, *changed);
    }
  }
  EXPECT_GT(accepted, 5);
  EXPECT_GT(refused, 5);
}

Bench pluto() {
  Bench bench;
  bench.wavelength_nm = 633.0;
  bench.slm = {1920, 1080, 8.0};
  bench.sensor_width = 2448;
  bench.sensor_height = 2048;
  return bench;
}

TEST(Design, TheFiguresAreThoseOfTheFormulas) {
  const auto made = design(pluto());
  ASSERT_TRUE(made);
  EXPECT_EQ(made->config.sensor.subapertures_across, 5);
  EXPECT_EQ(made->config.sensor.pupil_diameter_px, 1080.0);
  EXPECT_EQ(made->figures.subapertures, 19);
  EXPECT_EQ(made->figures.modes, 18);
  EXPECT_NEAR(made->figures.subaperture_mm, 1.728, 1e-9);
  EXPECT_NEAR(made->figures.lambda_d_px, 0.633 * 200.0 / 1.728 / 3.45, 1e-6);
  EXPECT_NEAR(made->figures.neighbours, 1.5 * recommended_spot_distance(1), 0.02);
  EXPECT_TRUE(made->findings.empty()) << made->findings.front().reason;
}

TEST(Design, TheOtherKeysOfTheConfigurationAreKept) {
  Config base;
  base.slm.display = "HDMI-1";
  base.camera.id = "Basler-1234";
  base.camera.settings.exposure_us = 700.0;
  base.optics.centre_px = Vec2{1.0, 2.0};
  base.optics.registered = PxPerCycle(0.0, 1.0, 1.0, 0.0);
  const auto made = design(pluto(), base);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->config.slm.display, "HDMI-1");
  EXPECT_EQ(made->config.camera.id, "Basler-1234");
  EXPECT_EQ(made->config.camera.settings.exposure_us, 700.0);
  EXPECT_FALSE(made->config.optics.centre_px);
  EXPECT_FALSE(made->config.optics.registered);
}

TEST(Design, ASmallBeamShrinksThePupilAndIsReported) {
  Bench bench = pluto();
  bench.beam_mm = 6.0;
  const auto made = design(bench);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->config.sensor.pupil_diameter_px, 750.0);
  ASSERT_FALSE(made->findings.empty());
  EXPECT_EQ(made->findings.front().limit, Limit::beam);
}

TEST(Design, MoreModesOfBrightSpotsTakeMoreSubapertures) {
  Bench bench = pluto();
  bench.modes = 28;
  bench.charge = 0;
  const auto made = design(bench);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->config.sensor.subapertures_across, 7);
  EXPECT_FALSE(made->config.tracking.mode_count);
}

/// An SLM of 1272 x 1024 pixels with a beam of 800 of them: 37 subapertures would lie under side
/// orders of the zeroth order.
Bench narrow_beam() {
  Bench bench;
  bench.wavelength_nm = 532.0;
  bench.focal_length_mm = 300.0;
  bench.slm = {1272, 1024, 12.5};
  bench.beam_mm = 10.0;
  bench.modes = 30;
  return bench;
}

TEST(Design, TheCoarsestLatticeWhoseShapesDetermineTheModesIsPreferred) {
  const auto made = design(narrow_beam());
  ASSERT_TRUE(made) << made.error().finding.reason;
  EXPECT_EQ(made->config.sensor.subapertures_across, 5);
  EXPECT_EQ(made->config.tracking.mode_count, 30);
  EXPECT_EQ(made->config.tracking.tracker, TrackerKind::fit);
  expect_measurable(narrow_beam(), *made);
  ASSERT_EQ(made->findings.back().limit, Limit::modes);
  EXPECT_NE(made->findings.back().help.find("--modes 18"), std::string::npos);
  Bench more = narrow_beam();
  more.modes = 48;
  const auto finer = design(more);
  ASSERT_TRUE(finer) << finer.error().finding.reason;
  EXPECT_EQ(finer->config.sensor.subapertures_across, 7);
  expect_measurable(more, *finer);
}

/// The brightest light of the zeroth order within a spot, relative to the spots' brightest pixel:
/// the far field with the light outside the subapertures minus that without it.
double stray_light(const Config& config) {
  const Roi& roi = config.camera.settings.roi;
  auto field =
      SensorField::make(config.sensor, config.slm.geometry, config.optics, roi.width, roi.height);
  if (!field) return INFINITY;
  field->propagate({}, {});
  const Image<std::complex<float>> with = field->far();
  field->set_outside(false);
  field->propagate({}, {});
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  const SpotLayout layout = spot_layout(spot_bench(config, *lattice));
  float peak = 0.0F, stray = 0.0F;
  for (int y = 0; y < roi.height; ++y) {
    for (int x = 0; x < roi.width; ++x) {
      peak = std::max(peak, std::norm(field->far().at(x, y)));
      const Vec2 at{double(x), double(y)};
      const bool is_in_spot = std::ranges::any_of(
          layout.spots_px, [&](Vec2 spot) { return norm(at - spot) < layout.lambda_d_px; });
      if (is_in_spot) stray = std::max(stray, std::norm(with.at(x, y) - field->far().at(x, y)));
    }
  }
  return double(stray) / double(peak);
}

TEST(Design, NoSpotLiesUnderSideOrdersOfTheZerothOrder) {
  for (const int modes : {18, 30, 48}) {
    Bench bench = narrow_beam();
    bench.modes = modes;
    const auto made = design(bench);
    ASSERT_TRUE(made) << made.error().finding.reason;
    EXPECT_LT(stray_light(made->config), 0.4) << modes << " modes";
  }
  Bench bench = narrow_beam();
  auto near = design(bench)->config;
  near.sensor.subapertures_across = 7;
  near.sensor.spacing = 0.3737;
  near.sensor.grooves = {169.0, 22.0};
  near.camera.settings.roi = {560, 240, 912, 1056};
  near.tracking.mode_count.reset();
  EXPECT_GT(stray_light(near), 1.0);
  const auto dark = check_zeroth_order(near);
  ASSERT_FALSE(dark);
  EXPECT_EQ(dark.error().field, "sensor.grooves");
}

TEST(Advice, AConfiguredSensorWithStrayLightHasItsErrorAndAWarning) {
  Config config;
  const auto clear = advise_on(config, 18, {.e_per_s = 1e9});
  ASSERT_TRUE(clear) << clear.error().reason;
  EXPECT_EQ(clear->warning, "");
  config.sensor.grooves = {130.0, 20.0};
  const auto near = advise_on(config, 18, {.e_per_s = 1e9});
  ASSERT_TRUE(near) << near.error().reason;
  EXPECT_NE(near->warning.find("zeroth order"), std::string::npos) << near->warning;
  EXPECT_GT(near->error_waves, 0.0);
}

TEST(Design, ABenchWhoseSpotsCannotLeaveTheZerothOrderIsRefused) {
  Bench bench = narrow_beam();
  bench.modes = 60;
  bench.charge = 0;
  const auto made = design(bench);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().finding.limit, Limit::orders) << made.error().finding.reason;
  EXPECT_NE(made.error().finding.reason.find("side orders"), std::string::npos);
  EXPECT_FALSE(made.error().changes.empty());
}

TEST(Design, WhereManySubaperturesDoNotFitTheShapesOfFewerSpotsGiveTheModes) {
  Bench bench = pluto();
  bench.slm = {1280, 768, 19.0};
  bench.sensor_width = 720;
  bench.sensor_height = 540;
  bench.camera_pitch_um = 6.9;
  bench.focal_length_mm = 300.0;
  bench.modes = 44;
  const auto made = design(bench);
  ASSERT_TRUE(made) << made.error().finding.reason;
  EXPECT_EQ(made->config.tracking.mode_count, 44);
  EXPECT_EQ(made->findings.back().limit, Limit::modes);
  bench.charge = 0;
  EXPECT_FALSE(design(bench));
}

TEST(Design, MoreModesThanAnyOddNumberAcrossDeterminesAreRefusedWithTheReason) {
  Bench bench = pluto();
  for (const int across : {63, 64}) {
    bench.modes = optimal_mode_count(across) + 1;
    const auto made = find_config(bench, {}, Shapes::used);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().limit, Limit::modes);
    EXPECT_NE(made.error().reason.find("63 subapertures across"), std::string::npos)
        << made.error().reason;
  }
}

TEST(Design, OneChangeIsProposedWhereOneIsEnough) {
  Bench bench = pluto();
  bench.beam_mm = 0.008;
  const auto made = design(bench);
  ASSERT_FALSE(made);
  ASSERT_EQ(made.error().changes.size(), 1U);
  EXPECT_EQ(made.error().changes.front().options, "--beam 8.649");
}

struct Impossible {
  const char* what;
  Limit limit;
  void (*change)(Bench&);
  const char* helps;  ///< one of the proposed options
};

TEST(Design, EachLimitIsNamedWithAChangeThatHelps) {
  const Impossible all[] = {
      {"a lens too long for the camera", Limit::region,
       [](Bench& b) {
         b.modes = 18;
         b.focal_length_mm = 1500.0;
       },
       "--focal-length"},
      {"spots just too close", Limit::neighbours,
       [](Bench& b) {
         b.modes = 18;
         b.focal_length_mm = 1100.0;
       },
       "--focal-length"},
      {"a lens too short for the pixels", Limit::scale, [](Bench& b) { b.focal_length_mm = 10.0; },
       "--focal-length"},
      {"a small beam", Limit::beam,
       [](Bench& b) {
         b.beam_mm = 0.5;
         b.focal_length_mm = 50.0;
       },
       "--beam"},
      {"many modes on a small SLM", Limit::orders,
       [](Bench& b) {
         b.slm = {400, 300, 20.0};
         b.focal_length_mm = 50.0;
         b.modes = 40;
         b.charge = 0;
       },
       "--modes"},
      {"a tiny SLM", Limit::grating,
       [](Bench& b) {
         b.slm = {64, 48, 20.0};
         b.focal_length_mm = 60.0;
         b.modes = 60;
       },
       "--slm"},
      {"more modes than any sensor", Limit::modes, [](Bench& b) { b.modes = 500; }, "--modes"}};
  for (const Impossible& one : all) {
    SCOPED_TRACE(one.what);
    Bench bench = pluto();
    one.change(bench);
    const auto made = design(bench);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().finding.limit, one.limit) << made.error().finding.reason;
    const auto& changes = made.error().changes;
    EXPECT_TRUE(std::any_of(changes.begin(), changes.end(), [&one](const Change& change) {
      return change.options.find(one.helps) != std::string::npos;
    })) << (changes.empty() ? "no change" : changes.front().options);
    for (const Change& change : changes) EXPECT_TRUE(design(change.bench)) << change.options;
  }
}

}  // namespace
}  // namespace ovws::design
