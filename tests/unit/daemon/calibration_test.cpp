/// Calibrations: which sensor and bench they belong to, and that their files hold all of them.
#include "daemon/ovwsd/library/calibration.hpp"

#include <gtest/gtest.h>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using test::hologram_of;

Registration turned(double base_x_px = 20.0) {
  Registration registration;
  registration.px_per_cycle = {0.0, -900.0, 900.0, 0.0};
  registration.base_px = {base_x_px, 30.0};
  registration.t_taken_ns = 3;
  return registration;
}

class Calibrations : public testing::Test {
 protected:
  static BenchKey key_of(const Config& config,
                         const std::optional<Registration>& registration = std::nullopt) {
    return test::key_of(config, registration);
  }
  /// The respects in which they differ, in words.
  static std::string difference(const BenchKey& then, const BenchKey& now) {
    return words_of(differing(respect::kCalibration, then, now), then, now);
  }

  /// A measured matrix that differs slightly from the model's slopes.
  static Calibration measured(const Config& config, std::int64_t t_taken_ns = 5,
                              const std::optional<Registration>& registration = std::nullopt) {
    Calibration calibration;
    calibration.key = key_of(config, registration);
    calibration.key.tracking = calibrated_tracking(config.tracking);
    calibration.frames = 20;
    calibration.t_taken_ns = t_taken_ns;
    const auto lattice = make_lattice(config.sensor, config.slm.geometry).value();
    const ModeOperator model =
        slope_operator(lattice, config.sensor, config.tracking, calibration.key.px_per_cycle);
    InteractionMatrix& matrix = calibration.matrix;
    calibration.amplitude_waves = 0.15;
    matrix.modes_j = model.modes_j;
    matrix.amplitude_waves.assign(model.modes_j.size(), 0.15);
    matrix.amplitude_waves[1] = 0.075;
    matrix.slopes = (1.01 * model.slopes).cast<float>().cast<double>();
    matrix.standard_error =
        Eigen::MatrixXd::Constant(model.slopes.rows(), model.slopes.cols(), 1.0 / 64.0);
    matrix.lost_spots = {2};
    matrix.slopes.middleRows(4, 2).setZero();
    matrix.dropped = {{200, "it moves no spot"}};
    matrix.drift_px = 0.25;
    matrix.drift_noise_px = 0.125;
    calibration.comparison = compare(matrix, model);
    calibration.mode_operator = mode_operator_of(calibration);
    const std::optional<CameraSettings> settings = config.camera.settings;
    const std::vector<Mode> aberration{{3, 0.05}};
    calibration.origin = std::make_shared<const json>(
        make_origin({calibration.key, aberration, settings, registration, nullptr}));
    return calibration;
  }

  const Config config_ = test::small_bench();
};

TEST_F(Calibrations, BelongToAllThatMovesTheirSpots) {
  const BenchKey key = key_of(config_);
  EXPECT_EQ(difference(key, key), "");
  const auto words = [&](auto change) {
    Config other = config_;
    change(other);
    return difference(key, key_of(other));
  };
  EXPECT_EQ(words([](Config& c) { c.sensor.charge = 2; }), "sensor.charge was 1, and is 2");
  EXPECT_EQ(words([](Config& c) { c.sensor.grid = Grid::square; }),
            "sensor.grid was \"hexagonal\", and is \"square\"");
  EXPECT_EQ(words([](Config& c) { c.tracking.tracker = TrackerKind::centroid; }),
            "tracking.tracker was \"fit\", and is \"centroid\"");
  EXPECT_EQ(words([](Config& c) { c.tracking.kernel_radius = 0.4; }).find("tracking.kernel_radius"),
            0U);
  EXPECT_EQ(words([](Config& c) { c.tracking.mode_operator = OperatorKind::measured; }), "");
  EXPECT_EQ(difference(key, key_of(config_, turned())), "the registration is another one");
  Config moved = config_;
  moved.camera.settings.roi.x += 16;  // the base spot stays: it is the registration's
  EXPECT_EQ(difference(key_of(config_, turned()), key_of(moved, turned())),
            "camera.roi.x was 16, and is 32");
  BenchKey camera = key;
  camera.camera["serial"] = "TWIN0002";
  EXPECT_EQ(difference(key, camera), "camera.serial was \"TWIN0001\", and is \"TWIN0002\"");
  camera.camera = nullptr;  // not yet known
  EXPECT_EQ(difference(key, camera), "");
}

TEST_F(Calibrations, AreTheSameWithinTheNoiseOfARegistration) {
  const BenchKey key = key_of(config_, turned());
  Registration again = turned(20.05);
  again.px_per_cycle = {0.3, -900.3, 899.8, -0.2};
  EXPECT_EQ(difference(key, key_of(config_, again)), "");
  const double lambda_d_px = 900.0 / config_.sensor.pupil_diameter_px * 3.0;
  EXPECT_NE(difference(key, key_of(config_, turned(20.0 + lambda_d_px))), "");
  again.px_per_cycle = {0.0, -909.0, 909.0, 0.0};
  EXPECT_NE(difference(key, key_of(config_, again)), "");
}

TEST_F(Calibrations, AreFoundAgainBitForBit) {
  const Calibration before = measured(config_, 7, turned());
  const auto after = calibration_from(calibration_content(before));
  ASSERT_TRUE(after) << after.error().reason;
  EXPECT_EQ(difference(before.key, after->key), "");
  EXPECT_EQ(after->frames, before.frames);
  EXPECT_EQ(after->t_taken_ns, 7);
  EXPECT_EQ(*after->origin, *before.origin);
  EXPECT_EQ(after->amplitude_waves, 0.15);
  EXPECT_EQ(after->matrix.amplitude_waves, before.matrix.amplitude_waves);
  EXPECT_EQ(after->matrix.modes_j, before.matrix.modes_j);
  EXPECT_EQ(after->matrix.slopes, before.matrix.slopes);
  EXPECT_EQ(after->matrix.standard_error, before.matrix.standard_error);
  EXPECT_EQ(after->matrix.lost_spots, before.matrix.lost_spots);
  ASSERT_EQ(after->matrix.dropped.size(), 1U);
  EXPECT_EQ(after->matrix.dropped[0].j, 200);
  EXPECT_EQ(after->matrix.drift_px, 0.25);
  EXPECT_EQ(after->mode_operator.slopes, before.mode_operator.slopes);
}

/// The state of a sensor with this configuration.
SensorState state_of(const Config& config) {
  SensorState state;
  state.sensor = config.sensor;
  state.tracking = config.tracking;
  state.roi = config.camera.settings.roi;
  auto slm = std::make_shared<ActiveSlm>();
  slm->identity = slm_identity(hologram_of(config), false);
  state.slm = std::move(slm);
  return state;
}

TEST_F(Calibrations, TheNewestThatAppliesIsUsedAndARemovedOneIsNot) {
  const BenchOptics optics{config_.optics, config_.slm.geometry};
  Knowledge known;
  EXPECT_EQ(missing_calibration_reason(state_of(config_), known, optics),
            "there is no calibration");
  for (const std::int64_t t_taken_ns : {5, 6}) {
    known.calibrations.push_back(
        std::make_shared<const Calibration>(measured(config_, t_taken_ns)));
  }
  const auto applies = [&](const Config& config) {
    const auto found = calibration_for(state_of(config), known, optics);
    return found ? found->t_taken_ns : 0;
  };
  EXPECT_EQ(applies(config_), 6);
  Config other = config_;
  other.tracking.tracker = TrackerKind::centroid;
  EXPECT_EQ(applies(other), 0);
  const std::string why = missing_calibration_reason(state_of(other), known, optics);
  EXPECT_TRUE(why.ends_with("is not used: tracking.tracker was \"fit\", and is \"centroid\""))
      << why;
  EXPECT_EQ(remove_items<Calibration>(known, state_of(config_), optics).size(), 2U);
  EXPECT_EQ(applies(config_), 0);
}

TEST_F(Calibrations, WhoseFileDoesNotFitTogetherAreRefused) {
  const json whole = calibration_content(measured(config_));
  ASSERT_TRUE(calibration_from(whole));
  const auto field_with = [&](const char* key, const json& value) -> std::string {
    json content = whole;
    content[key] = value;
    const auto read = calibration_from(content);
    return read ? "" : read.error().field;
  };
  EXPECT_EQ(field_with("frames", "many"), "frames");
  EXPECT_EQ(field_with("t_taken_ns", 0.5), "t_taken_ns");
  EXPECT_EQ(field_with("modes_j", {3, 3}), "modes_j");
  EXPECT_EQ(field_with("modes_j", {3}), "amplitudes_waves");
  EXPECT_EQ(field_with("spots", 6), "slopes");
  EXPECT_EQ(field_with("slopes", "no base64"), "slopes");
  EXPECT_EQ(field_with("standard_error", ""), "standard_error");
  EXPECT_EQ(field_with("lost_spots", {-1}), "lost_spots[0]");
  EXPECT_EQ(field_with("lost_spots", {1000}), "lost_spots");
  EXPECT_EQ(field_with("origin", nullptr), "origin");
  EXPECT_EQ(field_with("surplus", 1), "surplus");
}

}  // namespace
}  // namespace ovws
