/// Each procedure measures a truth of the simulated bench, and the sensor uses what it found.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "daemon/ovwsd/procedures/calibration.hpp"
#include "daemon/ovwsd/procedures/lut.hpp"
#include "daemon/ovwsd/procedures/reference.hpp"
#include "daemon/ovwsd/procedures/registration.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "tests/support/simulated_bench.hpp"

namespace ovws {
namespace {

using test::SimulatedBench;
using test::small_daemon_config;
using test::small_twin_config;

constexpr double kTurn = 2.0 * std::numbers::pi;

Result<nlohmann::json> take_reference_on(SimulatedBench& bench, int frames) {
  return bench.run("reference.take", [frames](Bench& on) {
    return take_reference(on, {frames, false});
  });
}

/// The coefficient of mode j among mean_waves.
double wave_of(const SimulatedBench& bench, const std::vector<double>& waves, int j) {
  const std::vector<int>& modes_j = bench.sensor()->modes_j;
  const auto at = std::find(modes_j.begin(), modes_j.end(), j);
  return waves.empty() || at == modes_j.end() ? NAN : waves[std::size_t(at - modes_j.begin())];
}

TEST(Procedures, AReferenceIsTheZeroOfWhatIsMeasuredThen) {
  auto twin = small_twin_config();
  twin.truth.aberration = {{4, 0.05}};
  SimulatedBench bench(small_daemon_config(), twin);
  ASSERT_TRUE(bench.is_running());
  const auto taken = take_reference_on(bench, 30);
  ASSERT_TRUE(taken) << taken.error().reason;
  EXPECT_EQ((*taken)["frames"], 30);
  ASSERT_TRUE(bench.sensor()->reference);
  EXPECT_NEAR(wave_of(bench, bench.mean_waves(20), 4), 0.0, 0.01);
  ASSERT_TRUE(bench.edit(set_aberration({{4, 0.1}})));
  EXPECT_NEAR(wave_of(bench, bench.mean_waves(20), 4), 0.1, 0.01);
}

TEST(Procedures, AReferenceWithSaturatedSpotsIsRefused) {
  auto twin = small_twin_config();
  twin.truth.peak_electrons *= 4.0;
  SimulatedBench bench(small_daemon_config(), twin);
  ASSERT_TRUE(bench.is_running());
  const auto taken = take_reference_on(bench, 10);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().field, "camera.exposure_us");
  EXPECT_FALSE(bench.sensor()->reference);
}

TEST(Procedures, ARegistrationFindsHowTheCameraStands) {
  auto twin = small_twin_config();
  twin.truth.geometry.rotation_deg = 20.0;
  twin.truth.geometry.magnification = 1.05;
  Registration found;
  SimulatedBench bench(small_daemon_config(), twin);
  ASSERT_TRUE(bench.is_running());
  const auto run = bench.run("registration.run", [&](Bench& on) -> Result<nlohmann::json> {
    auto measured = measure_registration(on, bench.config().slm.geometry, 2);
    if (!measured) return fail(measured.error());
    found = *measured;
    if (auto used = on.use(use_registration(*measured)); !used) return fail(used.error());
    return nlohmann::json{};
  });
  ASSERT_TRUE(run) << run.error().reason;
  const double expected = px_per_cycle(bench.config().optics, bench.config().slm.geometry).scale();
  EXPECT_NEAR(found.px_per_cycle.rotation_deg(), 20.0, 0.1);
  EXPECT_NEAR(found.px_per_cycle.scale(), 1.05 * expected, 0.002 * expected);
  EXPECT_NEAR(norm(found.base_px - twin.truth.geometry.centre_px), 0.0, 0.3);
  ASSERT_TRUE(take_reference_on(bench, 20));
  ASSERT_TRUE(bench.edit(set_aberration({{3, 0.1}})));
  EXPECT_NEAR(wave_of(bench, bench.mean_waves(20), 3), 0.1, 0.01);
}

TEST(Procedures, ACalibrationReadsWhatTheSlmShows) {
  MeasuredCalibration found;
  SimulatedBench bench;
  ASSERT_TRUE(bench.is_running());
  ASSERT_TRUE(take_reference_on(bench, 20));
  const auto run = bench.run("calibration.run", [&](Bench& on) -> Result<nlohmann::json> {
    const std::uint64_t epoch = on.sensor()->sensor_epoch;
    auto measured = measure_calibration(on, bench.config().slm.geometry, {0.1, 5, {1, 2, 3, 4, 5}});
    if (!measured) return fail(measured.error());
    found = *measured;
    if (auto used = on.use(use_calibration(epoch, *measured)); !used) return fail(used.error());
    return nlohmann::json{};
  });
  ASSERT_TRUE(run) << run.error().reason;
  EXPECT_TRUE(found.matrix.dropped.empty());
  ASSERT_TRUE(bench.edit(set_aberration({{5, 0.08}})));
  const auto waves = bench.mean_waves(20);
  EXPECT_NEAR(wave_of(bench, waves, 5), 0.08, 0.006);
  EXPECT_NEAR(wave_of(bench, waves, 4), 0.0, 0.006);
}

class LutProcedure : public testing::TestWithParam<std::pair<double, double>> {};

/// By the truth's law, 2 pi depth (grey / 256)^gamma.
TEST_P(LutProcedure, FindsThePhaseOfEveryGreyLevel) {
  const auto [gamma, depth_waves] = GetParam();
  auto twin = small_twin_config();
  twin.slm.gamma = gamma;
  twin.slm.depth_waves = depth_waves;
  MeasuredLut found;
  SimulatedBench bench(small_daemon_config(), twin);
  ASSERT_TRUE(bench.is_running());
  const auto run = bench.run("lut.run", [&](Bench& on) -> Result<nlohmann::json> {
    auto measured = measure_lut(on, bench.config().slm.geometry, {17, 2});
    if (!measured) return fail(measured.error());
    found = *measured;
    if (auto used = on.use(use_lut(std::move(*measured))); !used) return fail(used.error());
    return nlohmann::json{};
  });
  ASSERT_TRUE(run) << run.error().reason;
  double square = 0.0;
  for (int grey = 0; grey < 256; ++grey) {
    const double truth_rad = kTurn * depth_waves * std::pow(grey / 256.0, gamma);
    square += std::pow(found.response.phase_rad[std::size_t(grey)] - truth_rad, 2) / 256.0;
  }
  EXPECT_LT(std::sqrt(square), 0.05);
  EXPECT_EQ(found.response.falls(), depth_waves < 0.0);
  EXPECT_EQ(found.table.reason.empty(), std::abs(depth_waves) >= 1.0);
  EXPECT_TRUE(bench.sensor()->slm->lut);
}
INSTANTIATE_TEST_SUITE_P(Slms, LutProcedure,
                         testing::Values(std::pair{1.4, 0.9}, std::pair{1.4, -1.2},
                                         std::pair{0.7, 1.1}));

TEST(Procedures, AProcedureThatFailsGivesTheSensorBack) {
  SimulatedBench bench;
  ASSERT_TRUE(bench.is_running());
  const auto before = bench.sensor();
  const auto run = bench.run("calibration.run", [&](Bench& on) -> Result<nlohmann::json> {
    if (auto shown = on.show({{4, 0.1}}); !shown) return fail(shown.error());
    return fail(Errc::refused, "", "as the test wants");
  });
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().reason, "as the test wants");
  EXPECT_EQ(bench.sensor()->aberration.size(), before->aberration.size());
  EXPECT_TRUE(bench.edit(set_aberration({{4, 0.1}})));
}

TEST(Procedures, ACancelledProcedureEndsAndGivesTheSensorBack) {
  SimulatedBench bench;
  ASSERT_TRUE(bench.is_running());
  std::thread canceller;
  const auto run = bench.run("calibration.run", [&](Bench& on) -> Result<nlohmann::json> {
    if (auto shown = on.show({{4, 0.1}}); !shown) return fail(shown.error());
    canceller = std::thread([&bench] { bench.cancel(); });
    const auto spots = on.spots(1'000'000);
    EXPECT_FALSE(spots);
    return fail(spots.error());
  });
  canceller.join();
  ASSERT_FALSE(run);
  EXPECT_TRUE(bench.sensor()->aberration.empty());
}

}  // namespace
}  // namespace ovws
