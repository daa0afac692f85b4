/// Calibrations: which sensor and bench they belong to, and that they survive a restart.
#include "daemon/ovwsd/sensor/calibration.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/sensor/calibration_file.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::hologram_of;
using test::kCamera;

Registration turned(double base_x_px = 20.0) {
  Registration registration;
  registration.px_per_cycle = {0.0, -900.0, 900.0, 0.0};
  registration.base_px = {base_x_px, 30.0};
  registration.t_taken_ns = 3;
  return registration;
}

class Calibrations : public testing::Test {
 protected:
  Calibrations() { fs::remove_all(folder_); }
  ~Calibrations() override { fs::remove_all(folder_); }

  /// The part of a daemon, just started with this configuration, that keeps calibrations.
  struct Started {
    Started(const Config& configured, const std::string& folder)
        : config(configured),
          store({folder}, events),
          bench(config, hologram_of(config)),
          kept(CalibrationKind{&bench}, store, events) {
      add_calibrations(known, kept.load());
    }
    void put(Calibration calibration) {
      const std::string name = kept.kind().name(calibration);
      std::vector<std::string> names;
      for (const auto& one : replace_calibration(known, std::move(calibration))) {
        if (kept.kind().name(*one) != name) names.push_back(kept.kind().name(*one));
      }
      kept.keep(*known.calibrations.back(), names);
    }
    /// The latest calibration that belongs to `key`.
    std::shared_ptr<const Calibration> find(const CalibrationKey& key) const {
      std::shared_ptr<const Calibration> found;
      for (const auto& one : known.calibrations) {
        if (differences(one->key, key).empty()) found = one;
      }
      return found;
    }
    Config config;
    StreamQueue queue;
    Events events{queue};
    DaemonStore store;
    ReferenceBench bench;
    KeptCalibrations kept;
    Knowledge known;
  };
  std::unique_ptr<Started> started(const Config& config) const {
    return std::make_unique<Started>(config, folder_);
  }

  static CalibrationKey key_of(const Config& config,
                               const std::optional<Registration>& registration = std::nullopt) {
    return calibration_key(
        reference_key(config.sensor, config.tracking, config.camera.settings.roi), config.optics,
        config.slm.geometry, registration, camera_json(kCamera));
  }

  /// A measured matrix that differs slightly from the model's slopes.
  static Calibration measured(const Started& daemon, const Config& config,
                              std::int64_t t_taken_ns = 5,
                              const std::optional<Registration>& registration = std::nullopt) {
    Calibration calibration;
    calibration.key = key_of(config, registration);
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
    const std::optional<CameraInfo> camera = kCamera;
    const std::vector<Mode> aberration{{3, 0.05}};
    calibration.origin = std::make_shared<const json>(daemon.bench.origin(
        {calibration.key.sensor, aberration, settings, camera, registration, nullptr}));
    return calibration;
  }

  const std::string folder_ = own_folder("calibrations");
  const Config config_ = test::small_bench();
};

TEST_F(Calibrations, BelongToAllThatMovesTheirSpots) {
  const CalibrationKey key = key_of(config_);
  EXPECT_TRUE(differences(key, key).empty());
  const auto names = [&](auto change) {
    Config other = config_;
    change(other);
    return differences(key, key_of(other));
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names([](Config& c) { c.sensor.charge = 2; }), Names{"charge"});
  EXPECT_EQ(names([](Config& c) { c.sensor.grid = Grid::square; }), Names{"grid"});
  EXPECT_EQ(names([](Config& c) { c.sensor.subapertures_across = 2; }),
            Names{"subapertures_across"});
  EXPECT_EQ(names([](Config& c) { c.sensor.spacing = 0.3; }), Names{"spacing"});
  EXPECT_EQ(names([](Config& c) { c.tracking.tracker = TrackerKind::weighted; }), Names{"tracker"});
  EXPECT_EQ(names([](Config& c) { c.tracking.kernel_radius = 0.4; }), Names{"kernel_radius"});
  EXPECT_EQ(names([](Config& c) { c.tracking.mode_operator = OperatorKind::measured; }), Names{});
  EXPECT_EQ(differences(key, key_of(config_, turned())), Names{"registration"});
  EXPECT_EQ(names([](Config& c) { c.camera.settings.roi.x += 16; }), Names{"roi"});
  Config moved = config_;
  moved.camera.settings.roi.x += 16;  // the base spot stays: it is the registration's
  EXPECT_EQ(differences(key_of(config_, turned()), key_of(moved, turned())), Names{"roi"});
  CalibrationKey camera = key;
  camera.camera["serial"] = "TWIN0002";
  EXPECT_EQ(differences(key, camera), Names{"camera"});
  camera.camera = nullptr;  // not yet known
  EXPECT_TRUE(differences(key, camera).empty());
}

TEST_F(Calibrations, AreTheSameWithinTheNoiseOfARegistration) {
  const CalibrationKey key = key_of(config_, turned());
  Registration again = turned(20.05);
  again.px_per_cycle = {0.3, -900.3, 899.8, -0.2};
  EXPECT_TRUE(differences(key, key_of(config_, again)).empty());
  EXPECT_FALSE(differences(key, key_of(config_, turned(20.0 + key.lambda_d_px))).empty());
  again.px_per_cycle = {0.0, -909.0, 909.0, 0.0};
  EXPECT_FALSE(differences(key, key_of(config_, again)).empty());
}

TEST_F(Calibrations, AreFoundAgainBitForBit) {
  auto daemon = started(config_);
  const Calibration before = measured(*daemon, config_, 7, turned());
  daemon->put(before);
  const auto after = started(config_)->find(key_of(config_, turned()));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->sha256.size(), 64U);
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
  ASSERT_EQ(after->comparison.modes.size(), before.comparison.modes.size());
  EXPECT_NEAR(after->comparison.modes[3].factor, 1.01, 1e-4);
}

/// The state of a sensor with this configuration.
SensorState state_of(const Config& config) {
  SensorState state;
  state.sensor = config.sensor;
  state.tracking = config.tracking;
  state.roi = config.camera.settings.roi;
  state.slm = std::make_shared<const ActiveSlm>();
  return state;
}

TEST_F(Calibrations, OneTakesThePlaceOfTheOneBeforeAndOneThatIsDroppedIsGone) {
  auto daemon = started(config_);
  const BenchOptics optics{config_.optics, config_.slm.geometry};
  EXPECT_EQ(missing_calibration_reason(state_of(config_), daemon->known, optics),
            "there is no calibration");
  daemon->put(measured(*daemon, config_, 5, turned()));
  Registration again = turned(20.05);
  again.t_taken_ns = 8;
  daemon->put(measured(*daemon, config_, 9, again));
  daemon->put(measured(*daemon, config_, 6));
  EXPECT_EQ(daemon->find(key_of(config_, turned()))->t_taken_ns, 9);
  EXPECT_EQ(daemon->find(key_of(config_))->t_taken_ns, 6);
  auto next = started(config_);
  EXPECT_EQ(next->find(key_of(config_, turned()))->t_taken_ns, 9);
  const auto taken = remove_calibrations(next->known, key_of(config_, turned()));
  ASSERT_EQ(taken.size(), 1U);
  next->kept.drop({next->kept.kind().name(*taken[0])},
                  [](const Result<void>& dropped) { EXPECT_TRUE(dropped); });
  EXPECT_FALSE(next->find(key_of(config_, turned())));
  EXPECT_TRUE(next->find(key_of(config_)));
  next = started(config_);
  EXPECT_FALSE(next->find(key_of(config_, turned())));
  EXPECT_TRUE(next->find(key_of(config_)));
  Config other = config_;
  other.tracking.tracker = TrackerKind::weighted;
  const std::string why = missing_calibration_reason(state_of(other), next->known, optics);
  EXPECT_TRUE(why.ends_with("was measured with another tracker")) << why;
}

TEST_F(Calibrations, OfAnotherBenchAreNotUsed) {
  auto daemon = started(config_);
  daemon->put(measured(*daemon, config_));
  Config other = config_;
  other.slm.geometry.width_px = 192;
  EXPECT_FALSE(started(other)->find(key_of(other)));
  EXPECT_TRUE(started(config_)->find(key_of(config_)));
}

TEST_F(Calibrations, OfAnotherLutAreFoundWhenItIsAsItWas) {
  started(config_)->put(measured(*started(config_), config_));
  ActiveSlm configured, other;
  configured.hologram.slm = other.hologram.slm = config_.slm.geometry;
  configured.identity = slm_identity(configured.hologram, false);
  other.hologram.lut[200] = 7;
  other.identity = slm_identity(other.hologram, true);
  StreamQueue queue;
  Events events{queue};
  DaemonStore store({folder_}, events);
  ReferenceBench bench(config_, configured.hologram);
  KeptCalibrations kept(CalibrationKind{&bench}, store, events);
  bench.use_slm(other);
  EXPECT_TRUE(kept.load().empty());
  EXPECT_TRUE(kept.load_again().empty());
  bench.use_slm(configured);
  EXPECT_EQ(kept.load_again().size(), 1U);
  EXPECT_TRUE(kept.load_again().empty()) << "once";
}

TEST_F(Calibrations, WhoseFileDoesNotFitTogetherAreRefused) {
  auto daemon = started(config_);
  const json whole = calibration_content(measured(*daemon, config_));
  ASSERT_TRUE(calibration_from(whole, config_));
  const auto field_with = [&](const char* key, const json& value) -> std::string {
    json content = whole;
    content[key] = value;
    const auto read = calibration_from(content, config_);
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
