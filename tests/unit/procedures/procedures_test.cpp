/// Each procedure measures a truth of the simulated bench, and the sensor uses what it found.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <utility>

#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/presentation.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "tests/support/simulated_bench.hpp"
#include "tests/unit/procedures/on_bench.hpp"

namespace ovws {
namespace {

using test::calibrate_on;
using test::SimulatedBench;
using test::small_daemon_config;
using test::small_twin_config;
using test::take_reference_on;

constexpr double kTurn = 2.0 * std::numbers::pi;

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
  const auto taken = take_reference_on(bench, 10);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().field, "camera.exposure_us");
  EXPECT_FALSE(bench.sensor()->reference);
}

Result<Registration> register_on(SimulatedBench& bench) {
  Registration found;
  const auto run = bench.run("registration.run", [&](Bench& on) -> Result<nlohmann::json> {
    auto measured = measure_registration(on, 2);
    if (!measured) return fail(measured.error());
    found = *measured;
    if (auto used = on.use(use_registration(*measured)); !used) return fail(used.error());
    return nlohmann::json{};
  });
  if (!run) return fail(run.error());
  return found;
}

TEST(Calibration, OfFitMeasuresTemplatesThatAreKept) {
  Config config = small_daemon_config();
  config.tracking.tracker = TrackerKind::fit;
  SimulatedBench bench(config, small_twin_config());
  EXPECT_TRUE(calibrate_on(bench, 0.03, {1, 2, 3}));  // without a reference
  ASSERT_TRUE(take_reference_on(bench, 20));
  const auto measured = calibrate_on(bench, 0.03, {});
  ASSERT_TRUE(measured) << measured.error().reason;
  ASSERT_TRUE(measured->shapes);
  EXPECT_EQ(measured->shapes->modes_j, measured->matrix.modes_j);
  EXPECT_EQ(measured->comparison.disagreement, Disagreement::none) << measured->comparison.words;
  const auto kept = bench.sensor()->calibration;
  ASSERT_TRUE(kept);
  const auto read = calibration_from(calibration_content(*kept));
  ASSERT_TRUE(read) << read.error().reason;
  EXPECT_EQ(differing(respect::kCalibration, read->key, kept->key), 0U);
  for (std::size_t i = 0; i < kept->shapes->spots.size(); ++i) {
    EXPECT_EQ(read->shapes->spots[i].per_wave, kept->shapes->spots[i].per_wave);
    EXPECT_EQ(read->shapes->spots[i].window, kept->shapes->spots[i].window);
  }
  auto damaged = calibration_content(*kept);
  damaged["shapes"]["side"] = 17;
  EXPECT_EQ(calibration_from(damaged).error().field, "shapes");
}

/// A client's change of the camera that was permitted before a job is part of what it restores.
TEST(Procedures, AJobRestoresWhatAClientSetJustBeforeIt) {
  SimulatedBench bench;
  std::promise<void> begun, may_end;
  std::atomic<bool> first{true};
  bench.optics().before_apply([&] {
    if (!first.exchange(false)) return;
    begun.set_value();
    may_end.get_future().wait();
  });
  CameraSet change;
  change.put(&CameraSettings::exposure_us, 900.0);
  auto lease = bench.leases().take(Request::set_camera);
  ASSERT_TRUE(lease);
  std::atomic<bool> accepted{false};
  bench.camera_actor().change(
      change, [&accepted, lease = std::move(*lease)](const Result<CameraSnapshot>& set) mutable {
        accepted = bool(set);
        lease.reset();
      });
  begun.get_future().wait();
  std::thread client([&] { may_end.set_value(); });
  const auto run = bench.run("test", [&](Bench& on) -> Result<nlohmann::json> {
    EXPECT_TRUE(accepted) << "the job begins when the change has ended";
    CameraSet own;
    own.put(&CameraSettings::exposure_us, 500.0);
    if (auto set = on.set_camera(own); !set) return fail(set.error());
    return nlohmann::json{};
  });
  client.join();
  bench.optics().before_apply({});
  ASSERT_TRUE(run) << run.error().reason;
  EXPECT_EQ(bench.camera().settings.exposure_us, 900.0);
}

/// Whatever was measured with a registration stays in use if the same map is found again.
TEST(Procedures, ARegistrationOfAnUnchangedBenchChangesNothing) {
  SimulatedBench bench;
  const auto first = register_on(bench);
  ASSERT_TRUE(first) << first.error().reason;
  ASSERT_TRUE(take_reference_on(bench, 20));
  ASSERT_TRUE(calibrate_on(bench, 0.1, {1, 2, 3, 4, 5}));
  const SensorView before = bench.sensor();
  for (int k = 0; k < 3; ++k) {
    const auto again = register_on(bench);
    ASSERT_TRUE(again) << again.error().reason;
    const SensorView now = bench.sensor();
    EXPECT_EQ(now->registration->base_px, before->registration->base_px);
    EXPECT_EQ(now->registration->px_per_cycle, before->registration->px_per_cycle);
    EXPECT_EQ(now->registration->t_taken_ns, again->t_taken_ns);
    EXPECT_EQ(now->sensor_epoch, before->sensor_epoch);
    EXPECT_EQ(now->reference, before->reference);
    EXPECT_EQ(now->calibration, before->calibration);
    EXPECT_FALSE(bench.mean_waves(10).empty());
  }
  twin::Truth moved = bench.optics().truth();
  moved.geometry.centre_px.x += 2.0;
  bench.optics().set_truth(moved);
  const auto other = register_on(bench);
  ASSERT_TRUE(other) << other.error().reason;
  EXPECT_EQ(bench.sensor()->registration->base_px, other->base_px);
  EXPECT_FALSE(bench.sensor()->reference);
  EXPECT_NE(bench.sensor()->obstacle.reason.find("expected spot positions"), std::string::npos);
}

TEST(Procedures, ABetterRegistrationReplacesAPoorOne) {
  SimulatedBench bench;
  auto poor = register_on(bench);
  ASSERT_TRUE(poor) << poor.error().reason;
  poor->base_px.x += 1.0;
  poor->residual_px = 1.0;
  ASSERT_TRUE(bench.edit(forget_registration()));
  ASSERT_TRUE(bench.edit(use_registration(*poor)));
  ASSERT_EQ(bench.sensor()->registration->base_px, poor->base_px);
  const auto better = register_on(bench);
  ASSERT_TRUE(better) << better.error().reason;
  EXPECT_EQ(bench.sensor()->registration->base_px, better->base_px);
}

twin::CameraGeometry camera_at(double rotation_deg, twin::Mirror mirror, double magnification,
                               Vec2 centre_px) {
  twin::CameraGeometry geometry;
  geometry.rotation_deg = rotation_deg;
  geometry.mirror = mirror;
  geometry.magnification = magnification;
  geometry.centre_px = centre_px;
  return geometry;
}

class CameraPose : public testing::TestWithParam<twin::CameraGeometry> {};

TEST_P(CameraPose, IsRegisteredCalibratedAndThenMeasuredWith) {
  const twin::CameraGeometry& truth = GetParam();
  auto twin = small_twin_config();
  twin.truth.geometry = truth;
  SimulatedBench bench(small_daemon_config(), twin);
  const auto found = register_on(bench);
  ASSERT_TRUE(found) << found.error().reason;
  const double expected = px_per_cycle(bench.config().optics, bench.config().slm.geometry).scale();
  EXPECT_EQ(found->px_per_cycle.mirrored(), truth.mirror != twin::Mirror::none);
  EXPECT_NEAR(found->px_per_cycle.scale(), truth.magnification * expected, 0.002 * expected);
  EXPECT_NEAR(norm(found->base_px - truth.centre_px), 0.0, 0.3);
  if (truth.mirror == twin::Mirror::none) {
    EXPECT_NEAR(found->px_per_cycle.rotation_deg(), truth.rotation_deg, 0.1);
  }
  ASSERT_TRUE(take_reference_on(bench, 20));
  ASSERT_TRUE(bench.edit(set_aberration({{3, 0.1}, {4, -0.05}})));
  const auto by_map = bench.mean_waves(20);
  for (const int j : {1, 2, 3, 4, 5}) {
    const double shown = j == 3 ? 0.1 : j == 4 ? -0.05 : 0.0;
    EXPECT_NEAR(wave_of(bench, by_map, j), shown, 0.01) << "by the map alone, j = " << j;
  }
  ASSERT_TRUE(bench.edit(set_aberration({})));
  const auto calibration = calibrate_on(bench, 0.1, {1, 2, 3, 4, 5});
  ASSERT_TRUE(calibration) << calibration.error().reason;
  EXPECT_EQ(calibration->matrix.modes_j, (std::vector<int>{1, 2, 3, 4, 5}));
  EXPECT_TRUE(calibration->matrix.lost_spots.empty());
  EXPECT_EQ(calibration->comparison.disagreement, Disagreement::none);
  ASSERT_TRUE(bench.edit(set_aberration({{5, 0.08}})));
  const auto waves = bench.mean_waves(20);
  for (const int j : {1, 2, 3, 4, 5}) {
    EXPECT_NEAR(wave_of(bench, waves, j), j == 5 ? 0.08 : 0.0, 0.006) << "j = " << j;
  }
}
INSTANTIATE_TEST_SUITE_P(Cameras, CameraPose,
                         testing::Values(camera_at(0.0, twin::Mirror::none, 1.0, {127.5, 127.5}),
                                         camera_at(3.0, twin::Mirror::none, 1.0, {127.5, 127.5}),
                                         camera_at(33.0, twin::Mirror::none, 1.05, {137.5, 122.5}),
                                         camera_at(90.0, twin::Mirror::none, 1.0, {127.5, 127.5}),
                                         camera_at(0.0, twin::Mirror::x, 1.05, {127.5, 127.5}),
                                         camera_at(87.0, twin::Mirror::x, 0.95, {120.0, 130.0}),
                                         camera_at(20.0, twin::Mirror::y, 0.95, {127.5, 127.5})));

/// Near the sampling limit of the SLM a mode is poked by less, or left out with the reason.
TEST(Procedures, ACalibrationPokesOnlyWhatTheSlmCanShow) {
  auto daemon = small_daemon_config();
  auto twin = small_twin_config();
  daemon.sensor.grooves = twin.sensor.grooves = {143.0, 4.0};
  SimulatedBench bench(daemon, twin);
  ASSERT_TRUE(take_reference_on(bench, 10));
  const auto found = calibrate_on(bench, 0.2, {1, 2, 9});
  ASSERT_TRUE(found) << found.error().reason;
  ASSERT_EQ(found->matrix.modes_j, (std::vector<int>{1, 2}));
  EXPECT_EQ(found->matrix.amplitude_waves[0], 0.2);
  EXPECT_EQ(found->matrix.amplitude_waves[1], 0.1) << "the grating runs along x, too";
  ASSERT_EQ(found->matrix.dropped.size(), 1U);
  EXPECT_EQ(found->matrix.dropped[0].j, 9);
  EXPECT_NE(found->matrix.dropped[0].reason.find("the SLM cannot show it"), std::string::npos);
}

/// An SLM with the phase 2 pi depth (grey / 256)^gamma.
struct SlmLaw {
  double gamma = 1.0;
  double depth_waves = 1.0;

  double phase_rad(int grey) const { return kTurn * depth_waves * std::pow(grey / 256.0, gamma); }
};

struct LutFound {
  MeasuredLut lut;
  double error_rad = 0.0;        ///< of the response, RMS over the grey levels
  double table_error_rad = 0.0;  ///< of the phases that the LUT shows, RMS without piston
  double standard_error_rad = 0.0;
  bool used = false;
};

/// RMS over the phases that the SLM reaches, without their mean.
double table_error_rad(const SlmLaw& law, const PhaseLut& lut) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int k = 0; k < 256; ++k) {
    const double wanted = k / 256.0;
    const double needed = law.depth_waves < 0.0 && k > 0 ? 1.0 - wanted : wanted;
    if (needed > std::abs(law.depth_waves)) continue;
    const double off = std::remainder(law.phase_rad(lut[std::size_t(k)]) / kTurn - wanted, 1.0);
    sum += off;
    squares += off * off;
    ++count;
  }
  return kTurn * std::sqrt(squares / count - sum * sum / count / count);
}

Result<LutFound> lut_on(const SlmLaw& law, int levels, twin::Config twin = small_twin_config()) {
  twin.slm.gamma = law.gamma;
  twin.slm.depth_waves = law.depth_waves;
  LutFound found;
  SimulatedBench bench(small_daemon_config(), twin);
  const auto run = bench.run("lut.run", [&](Bench& on) -> Result<nlohmann::json> {
    auto measured = measure_lut(on, {levels, 2});
    if (!measured) return fail(measured.error());
    found.lut = *measured;
    if (auto used = on.use(use_lut(std::move(*measured))); !used) return fail(used.error());
    return nlohmann::json{};
  });
  if (!run) return fail(run.error());
  const PhaseResponse& response = found.lut.response;
  double square = 0.0, variance = 0.0;
  for (int grey = 0; grey < 256; ++grey) {
    square += std::pow(response.phase_rad[std::size_t(grey)] - law.phase_rad(grey), 2) / 256.0;
    variance += std::pow(response.standard_error_rad[std::size_t(grey)], 2) / 256.0;
  }
  found.error_rad = std::sqrt(square);
  found.standard_error_rad = std::sqrt(variance);
  found.table_error_rad = table_error_rad(law, found.lut.table.lut);
  found.used = bench.sensor()->slm->lut != nullptr;
  return found;
}

class LutProcedure : public testing::TestWithParam<SlmLaw> {};

TEST_P(LutProcedure, FindsThePhaseOfEveryGreyLevel) {
  const SlmLaw& law = GetParam();
  const auto found = lut_on(law, 17);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_LT(found->error_rad, 0.05);
  EXPECT_LT(found->table_error_rad, 0.05);
  EXPECT_EQ(found->lut.response.falls(), law.depth_waves < 0.0);
  EXPECT_EQ(found->lut.table.reason.empty(), std::abs(law.depth_waves) >= 1.0);
  EXPECT_TRUE(found->used);
}
INSTANTIATE_TEST_SUITE_P(Slms, LutProcedure,
                         testing::Values(SlmLaw{1.4, 0.9}, SlmLaw{1.4, -1.2}, SlmLaw{0.7, 1.1}));

/// Grey level 1 shows a tenth of a wave: no table can show smaller phases.
TEST(Procedures, ASteepPhaseResponseIsMeasuredAtMoreLevels) {
  const auto found = lut_on({0.4, 1.0}, 33);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_GT(found->lut.response.levels, 33);
  EXPECT_LT(found->error_rad, 0.02);
  EXPECT_LT(found->error_rad, 3.0 * found->standard_error_rad);
  EXPECT_LT(found->table_error_rad, 0.3) << "the best table has steps of a tenth of a wave";
}

TEST(Procedures, ALutWithoutASpotWhereItIsExpectedIsRefused) {
  auto dark = small_twin_config();
  dark.truth.peak_electrons = 1.0;
  auto displaced = small_twin_config();
  displaced.truth.geometry.centre_px = {60.0, 200.0};
  for (const auto& twin : {dark, displaced}) {
    const auto found = lut_on({}, 17, twin);
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().reason.find("no spot where the base spot is expected"),
              std::string::npos)
        << found.error().reason;
  }
}

TEST(Procedures, AProcedureThatFailsGivesTheSensorBack) {
  SimulatedBench bench;
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

TEST(Procedures, AProcedureBeginsAfterItsNumberWasTold) {
  using namespace std::chrono_literals;
  SimulatedBench bench;
  std::promise<void> begins;
  const auto begun = begins.get_future().share();
  std::atomic<bool> waits{false};
  auto lease = bench.leases().take(Request::run_job);
  ASSERT_TRUE(lease);
  const auto procedure = [&](Bench&) -> Result<nlohmann::json> {
    begins.set_value();
    return nlohmann::json{};
  };
  bench.procedures().start(
      std::move(*lease), {"calibration.run", procedure},
      [&](const Result<int>&) { waits = begun.wait_for(200ms) == std::future_status::timeout; });
  ASSERT_EQ(begun.wait_for(30s), std::future_status::ready);
  EXPECT_TRUE(waits);
}

TEST(Presentations, EveryOrderIsAnsweredEvenAfterAnException) {
  using namespace std::chrono_literals;
  SimulatedBench bench;
  const SlmGeometry& slm = bench.config().slm.geometry;
  Presentations presentations(bench.leases(), bench.procedures(), slm);
  SlmPresent order;
  order.type = PictureType::grey;
  order.shape = {slm.height_px, slm.width_px};
  order.lease_s = 100.0;
  std::promise<Result<PresentReport>> begun, waits, comes_later;
  presentations.present(order, std::string(std::size_t(slm.width_px * slm.height_px), '\0'),
                        [&](Result<PresentReport> done) { begun.set_value(std::move(done)); });
  const auto first = begun.get_future().get();
  ASSERT_TRUE(first) << first.error().reason;
  SlmPresent renewal;
  renewal.job = first->job;
  const auto answer = [](std::promise<Result<PresentReport>>& to) {
    return [&to](Result<PresentReport> done) { to.set_value(std::move(done)); };
  };
  presentations.present(renewal, "", [&](const Result<PresentReport>&) {
    presentations.present(renewal, "", [](const Result<PresentReport>&) {
      throw std::runtime_error("no memory for this one either");
    });
    presentations.present(renewal, "", answer(waits));
    throw std::runtime_error("no memory for the reply");
  });
  auto refused = waits.get_future();
  ASSERT_EQ(refused.wait_for(30s), std::future_status::ready);
  EXPECT_EQ(refused.get().error().field, "job");
  presentations.present(renewal, "", answer(comes_later));
  auto later = comes_later.get_future();
  ASSERT_EQ(later.wait_for(30s), std::future_status::ready);
  EXPECT_EQ(later.get().error().field, "job");
}

}  // namespace
}  // namespace ovws
