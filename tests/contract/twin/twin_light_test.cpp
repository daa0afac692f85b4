/// The light in front of the sensor: deformable mirror and scintillation, for both kinds of bench.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "drivers/twin/array_model.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/deformable_mirror.hpp"
#include "drivers/twin/scintillation.hpp"
#include "drivers/twin/slm_model.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

std::vector<double> poke(std::size_t actuators, std::size_t which, double waves) {
  std::vector<double> commands(actuators);
  commands[which] = waves;
  return commands;
}

TEST(DeformableMirror, NineActuatorsAcrossAre69) {
  const auto positions = actuator_positions({});
  ASSERT_EQ(positions.size(), 69U);
  EXPECT_EQ(positions[34], (Vec2{0.0, 0.0}));
  EXPECT_EQ(positions[30], (Vec2{-1.0, 0.0})) << "on the pupil's edge";
  EXPECT_EQ(actuator_positions({.actuators_across = 2}).size(), 4U);
}

TEST(DeformableMirror, AnActuatorActsAtItsPlaceAndByTheCouplingAtItsNeighbour) {
  const MirrorConfig config;
  const DeformableMirror mirror(config, {-1.0, 0.25, 9}, {-1.0, 0.25, 9});
  const Eigen::MatrixXf waves = mirror.waves(poke(69, 34, 0.4));
  EXPECT_NEAR(waves(4, 4), 0.4, 1e-6);
  EXPECT_NEAR(waves(5, 4), 0.4 * 0.15, 1e-6);
  EXPECT_NEAR(waves(5, 3), 0.4 * 0.15 * 0.15, 1e-6);
  EXPECT_EQ(mirror.waves({}).norm(), 0.0F);
  EXPECT_NEAR(mirror.waves(poke(69, 30, 1.0))(0, 4), 1.0, 1e-6);
}

TEST(DeformableMirror, BendsTheLightOnTheSlmInsideThePupil) {
  const Config config = config_of(R"({"mirror": {"actuators_across": 9}})");
  SlmModel slm(config);
  slm.set_light({{}, {}, poke(69, 34, 0.2), {}});
  const auto waves = [&](int x, int y) {
    return std::arg(slm.incident().at(x, y)) / (2.0 * std::numbers::pi);
  };
  EXPECT_NEAR(waves(640, 384), 0.2, 1e-3);
  EXPECT_NEAR(waves(640 + 96, 384), 0.2 * 0.15, 1e-3);  // actuators are 96 pixels apart
  EXPECT_NEAR(waves(1200, 384), 0.0, 1e-6);
}

TEST(DeformableMirror, MovesTheSpotsOfAnArrayBesideTheActuatorApart) {
  const Config config = config_of(
      R"({"modulator": "fixed", "optics": {"focal_length_mm": 5.2, "camera_pitch_um": 5.3,
          "centre_px": [127, 127]}, "sensor": {"charge": 0}, "mirror": {"actuators_across": 5},
          "array": {"columns": 9, "rows": 9, "shape": "circle"}})");
  ArrayModel model(config);
  model.set_window({0, 0, 255, 255}, config.truth.geometry);
  const auto centre_x = [&](double at) {
    const Image<float> image = model.intensity({});
    double sum = 0.0, moment = 0.0;
    for (int y = 122; y <= 132; ++y) {
      for (int x = int(at) - 6; x <= int(at) + 7; ++x) {
        const double light = std::pow(double(image.at(x, y)), 2);
        sum += light;
        moment += light * x;
      }
    }
    return moment / sum;
  };
  const double right = 127 + 150 / 5.3, before = centre_x(right);
  const std::vector<double> commands = poke(21, 10, -0.3);
  model.set_light({{}, {}, commands, {}});
  // An actuator in the middle, 337.5 um from its neighbours: the slope of its Gaussian, by lambda
  // f.
  const double r = 150.0 / 337.5;
  const double slope = -0.3 * std::pow(0.15, r * r) * 2.0 * std::log(0.15) * r / 337.5;
  EXPECT_NEAR(centre_x(right) - before, slope * 632e-3 * 5.2e3 / 5.3, 0.1);
  model.set_light({});
  EXPECT_NEAR(centre_x(right), before, 1e-6);
}

TEST(DeformableMirror, ItsConfigurationIsStrict) {
  const auto fault = [](const std::string& json) {
    const auto config = parse_config(json);
    return config ? std::string("none") : config.error().field;
  };
  EXPECT_EQ(fault(R"({"mirror": {"actuators": 9}})"), "mirror.actuators");
  EXPECT_EQ(fault(R"({"mirror": {"actuators_across": 1}})"), "mirror.actuators_across");
  EXPECT_EQ(fault(R"({"mirror": {"coupling": 1.0}})"), "mirror.coupling");
  EXPECT_EQ(fault(R"({"scintillation": {"variance": -1}})"), "scintillation.variance");
  EXPECT_FALSE(config_of(R"({"mirror": null})").mirror);
}

TEST(DeformableMirror, ACommandDoesNotWithdrawAFrameThatHasBegun) {
  Bench bench(config_of(
      R"({"modulator": "fixed", "optics": {"focal_length_mm": 5.2, "camera_pitch_um": 5.3,
          "centre_px": [31, 31]}, "mirror": {}, "array": {"columns": 1, "rows": 1}})"));
  const std::jthread work([&](const std::stop_token& stop) { bench.work(stop); });
  const std::stop_source stop;
  const auto scene = [&](std::uint64_t begun, const std::shared_ptr<const Scene>& ready) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    return bench.scene(begun, ready, deadline, stop.get_token());
  };
  const Roi window{0, 0, 64, 64};
  const std::uint64_t begun = bench.begin(window);
  const auto first = scene(begun, nullptr);
  ASSERT_TRUE(first);
  bench.set_mirror(poke(69, 34, 0.1));
  EXPECT_EQ(scene(begun, first), first);
  const auto next = scene(bench.begin(window), nullptr);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->truth.mirror_waves, poke(69, 34, 0.1));
  EXPECT_NE(scene(bench.begin(window), first), first) << "begun after the command";
  Truth truth = bench.truth();
  truth.aberration = {{4, 0.1}};
  bench.set_truth(truth);
  EXPECT_NE(scene(begun, first), first) << "another change withdraws it";
}

TEST(Scintillation, HasTheVarianceAndTheCorrelationLength) {
  const ScintillationConfig config{.variance = 0.3, .scale_pupils = 0.1, .seed = 5};
  const Eigen::ArrayXXf amplitude =
      amplitude_screen(config, {-10.0, 0.05, 401}, {-10.0, 0.05, 401}).array();
  const Eigen::ArrayXXf intensity = amplitude.square();
  const double mean = double(intensity.mean());
  EXPECT_NEAR(mean, 1.0, 0.03);
  EXPECT_NEAR(double((intensity - float(mean)).square().mean()), 0.3, 0.04);
  // The logarithm's correlation at 0.1 pupil diameters, 0.2 radii: 4 points.
  const Eigen::ArrayXXf chi = amplitude.log() - amplitude.log().mean();
  const double at_scale = double((chi.topRows(397) * chi.bottomRows(397)).mean());
  EXPECT_NEAR(at_scale / double(chi.square().mean()), std::exp(-1.0), 0.05);
}

TEST(Scintillation, DimsTheLightOfBothBenches) {
  const ScintillationConfig config{.variance = 0.5, .scale_pupils = 0.3};
  const Config slm_bench = config_of("{}");
  SlmModel slm(slm_bench);
  slm.set_light({{}, {}, {}, config});
  const double step = 2.0 / 768.0;
  const float wanted = amplitude_screen(config, {(500 - 639.5) * step, 1.0, 1},
                                        {(300 - 383.5) * step, 1.0, 1})(0, 0);
  EXPECT_NEAR(std::abs(slm.incident().at(500, 300)), wanted, 1e-4);
  slm.set_light({});
  EXPECT_NEAR(std::abs(slm.incident().at(500, 300)), 1.0, 1e-4);

  const Config array = config_of(
      R"({"modulator": "fixed", "optics": {"focal_length_mm": 5.2, "camera_pitch_um": 5.3,
          "centre_px": [31, 31]}, "sensor": {"charge": 0},
          "array": {"columns": 1, "rows": 1, "pupil_mm": 5}})");
  ArrayModel model(array);
  model.set_window({0, 0, 63, 63}, array.truth.geometry);
  const float bright = model.intensity({}).at(31, 31);
  model.set_light({{}, {}, {}, config});
  const float middle = amplitude_screen(config, {0.0, 1.0, 1}, {0.0, 1.0, 1})(0, 0);
  EXPECT_NEAR(model.intensity({}).at(31, 31) / bright, middle * middle, 0.01);
}

}  // namespace
}  // namespace ovws::twin
