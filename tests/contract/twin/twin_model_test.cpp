/// The twin's models without display and network: configuration, light, noise, faults.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <thread>

#include "core/optics/hologram.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/pixel_packing.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

Image<std::uint8_t> sensor_hologram(const SensorConfig& sensor) {
  HologramConfig config;
  config.sensor = sensor;
  Image<std::uint8_t> grey;
  HologramRenderer::make(config)->render(HologramKind::sensor, {}, grey);
  return grey;
}

/// Centroid of the pixels brighter than half of the brightest one.
Vec2 centre_of_light(const Image<float>& image) {
  const float half = *std::max_element(image.pixels.begin(), image.pixels.end()) / 2;
  double sum = 0.0;
  Vec2 centre;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double light = image.at(x, y) > half ? double(image.at(x, y)) : 0.0;
      centre = centre + light * Vec2{double(x), double(y)};
      sum += light;
    }
  }
  return (1.0 / sum) * centre;
}

TEST(TwinConfig, EmptyMeansTheDefaultsOfTheBench) {
  const Config config = config_of("{}");
  EXPECT_EQ(config.slm.display, "DUMMY1");
  EXPECT_EQ(config.truth.geometry.centre_px, (Vec2{255.5, 255.5}));
  EXPECT_TRUE(config.truth.aberration.empty());
}

TEST(TwinConfig, AFileThatCannotBeReadIsNamed) {
  for (const std::string path : {"/", "/nonexistent/twin.json", "/dev/zero"}) {
    const auto config = load_config(path);
    ASSERT_FALSE(config);
    EXPECT_EQ(config.error().code, Errc::unavailable);
    EXPECT_TRUE(config.error().reason.starts_with(path + ": ")) << config.error().reason;
  }
}

TEST(TwinConfig, TheFileInTheRepositoryIsWhatEmptyMeans) {
  const auto file = load_config(OVWS_TWIN_JSON);
  ASSERT_TRUE(file) << file.error().field << " " << file.error().reason;
  const Config defaults = config_of("{}");
  EXPECT_EQ(file->truth.peak_electrons, defaults.truth.peak_electrons);
  EXPECT_EQ(file->truth.detector.read_noise_e, defaults.truth.detector.read_noise_e);
  EXPECT_EQ(file->truth.detector.quantum_efficiency, defaults.truth.detector.quantum_efficiency);
  EXPECT_EQ(file->truth.detector.full_well_e, defaults.truth.detector.full_well_e);
  EXPECT_EQ(file->truth.detector.black_level_dn, defaults.truth.detector.black_level_dn);
  EXPECT_EQ(file->truth.detector.prnu, defaults.truth.detector.prnu);
  EXPECT_EQ(file->sensor, defaults.sensor);
  EXPECT_EQ(file->modulator, defaults.modulator);
  EXPECT_EQ(file->array, defaults.array);
  EXPECT_EQ(file->dmd, defaults.dmd);
  EXPECT_EQ(file->truth.geometry, defaults.truth.geometry);
  EXPECT_EQ(file->truth.turbulence, defaults.truth.turbulence);
  EXPECT_EQ(file->camera.sensor_width, defaults.camera.sensor_width);
  EXPECT_EQ(file->slm.depth_waves, defaults.slm.depth_waves);
  EXPECT_EQ(file->light.diameter_px, defaults.light.diameter_px);
  EXPECT_EQ(file->control_endpoint, defaults.control_endpoint);
}

TEST(TwinConfig, AberrationsOfUnitAmplitudeBecomeRms) {
  const Config config =
      config_of(R"({"aberration": [{"n": 2, "m": -2, "waves": 1.0}], "norm": "unit"})");
  ASSERT_EQ(config.truth.aberration.size(), 1U);
  EXPECT_EQ(config.truth.aberration[0].j, 3);
  EXPECT_NEAR(config.truth.aberration[0].waves, 1.0 / std::sqrt(6.0), 1e-12);
}

TEST(TwinConfig, PhotonsAndPeakElectronsAreEachOthersInverse) {
  const Config config = config_of("{}");
  const double photons = BenchModel(config).photons_per_spot(config.truth);
  EXPECT_NEAR(BenchModel(config).peak_electrons_for(config.truth, photons),
              config.truth.peak_electrons, 1e-6);
}

TEST(BenchModel, AllLightOfTheSlmIsThatOfItsAreaInSpots) {
  const Config config = config_of("{}");
  BenchModel model(config);
  // A flat SLM sends all its light into the zeroth order, and this window holds nearly all of it.
  model.set_window({-556, -306, 1024, 1024}, {});
  const Image<float> light = model.intensity(Image<std::uint8_t>(1280, 768));
  const double sum = std::accumulate(light.pixels.begin(), light.pixels.end(), 0.0);
  const double photons =
      sum * config.truth.peak_electrons / config.truth.detector.quantum_efficiency;
  const double spot_area_px = std::numbers::pi * 76.8 * 76.8;
  EXPECT_NEAR(
      photons / BenchModel(config).photons_per_spot(config.truth) / (1280.0 * 768.0 / spot_area_px),
      1.0, 0.01);
}

TEST(BenchModel, OneVortexAloneIsAsBrightAsTheUnitSays) {
  Config config = config_of("{}");
  BenchModel model(config);
  // The vortex alone: outside the base subaperture a grating deflects the light.
  Image<std::uint8_t> grey(1280, 768);
  const Image<std::uint8_t> all = sensor_hologram(config.sensor);
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const bool inside = std::hypot(x - 639.5, y - 383.5) < 76.8;
      grey.at(x, y) = inside ? all.at(x, y) : std::uint8_t(128 * ((x + y) % 2));
    }
  }
  model.set_window({192, 192, 128, 128}, {});
  const Image<float> light = model.intensity(grey);
  EXPECT_NEAR(*std::max_element(light.pixels.begin(), light.pixels.end()), 1.0, 0.06);
  EXPECT_LT(light.at(63, 63), 0.02);
  EXPECT_LT(light.at(64, 64), 0.02);
}

TEST(BenchModel, AHiddenTiltMovesTheBrightSpotRightAndDownAsTheTruthSays) {
  Config config = config_of(R"({"sensor": {"charge": 0}})");
  BenchModel model(config);
  model.set_window({224, 224, 64, 64}, {});
  const Image<std::uint8_t> grey = sensor_hologram(config.sensor);
  const std::vector<Mode> tilts{{2, 0.8}, {1, 0.5}};  // dW/dx and dW/dy, both positive
  model.set_light({tilts, {}});
  config.truth.aberration = tilts;
  const Vec2 truth = BenchModel(config).true_spots_px(config.truth)[9] - Vec2{224, 224};
  EXPECT_GT(truth.x, 31.5 + 3.0);
  EXPECT_GT(truth.y, 31.5 + 2.0);
  EXPECT_GT(truth.x - 31.5, truth.y - 31.5);
  EXPECT_LT(norm(centre_of_light(model.intensity(grey)) - truth), 0.5);
}

TEST(BenchModel, AShadeTakesItsShareOfTheLightOfTheSubapertureBehindIt) {
  const Config config = config_of(
      R"({"sensor": {"charge": 0}, "shades": [{"x_px": 639.5, "y_px": 383.5, "radius_px": 77, "transmission": 0.25}]})");
  ASSERT_EQ(config.truth.shades.size(), 1U);
  BenchModel model(config);
  model.set_window({240, 240, 32, 32}, {});  // the middle subaperture's spot
  const Image<std::uint8_t> grey = sensor_hologram(config.sensor);
  const auto light = [&] {
    const Image<float> image = model.intensity(grey);
    return std::accumulate(image.pixels.begin(), image.pixels.end(), 0.0);
  };
  const double shaded = light();
  model.set_light({});
  EXPECT_NEAR(shaded / light(), 0.25, 0.05);  // the neighbours' light is in the window, too
}

TEST(BenchModel, ATooShallowSlmLeavesLightBehind) {
  const Config config = config_of(R"({"slm": {"depth_waves": 0.7}, "sensor": {"charge": 0}})");
  const Config perfect = config_of(R"({"sensor": {"charge": 0}})");
  const Image<std::uint8_t> grey = sensor_hologram(config.sensor);
  const auto peak = [&grey](const Config& c) {
    BenchModel model(c);
    model.set_window({224, 224, 64, 64}, {});
    const Image<float> light = model.intensity(grey);
    return double(*std::max_element(light.pixels.begin(), light.pixels.end()));
  };
  // A blazed grating of 0.7 waves has the efficiency sinc^2(0.3).
  const double x = 0.3 * std::numbers::pi;
  EXPECT_NEAR(peak(config) / peak(perfect), std::pow(std::sin(x) / x, 2), 0.08);
}

/// A running bench, and a hologram image to show on it.
class RunningBench : public ::testing::Test {
 protected:
  using Light = std::shared_ptr<const Scene>;

  Light scene(std::uint64_t begun, const Light& ready, milliseconds wait = milliseconds(20'000)) {
    return bench.scene(begun, ready, steady_clock::now() + wait, stop.get_token());
  }
  /// The scene with which a frame begun in this state is sent.
  Light sent(std::uint64_t begun) {
    Light ready = scene(begun, nullptr);
    for (Light next; (next = scene(begun, ready)) != ready;) ready = next;
    return ready;
  }
  void show(const Image<std::uint8_t>& grey) { bench.show({grey}, steady_clock::now()); }

  static constexpr Roi kWindow{192, 192, 128, 128};
  const Config config = config_of("{}");
  const Image<std::uint8_t> picture = sensor_hologram(config.sensor);
  std::stop_source stop;
  Bench bench{config};
  std::jthread worker{[this](const std::stop_token& token) { bench.work(token); }};
};

TEST_F(RunningBench, GivesTheLightOfWhatIsShownNow) {
  const auto dark = sent(bench.begin(kWindow));
  ASSERT_TRUE(dark);
  show(picture);
  const auto light = sent(bench.begin(kWindow));
  ASSERT_TRUE(light);
  EXPECT_GT(light->patterns[0].intensity->at(63, 55), 0.3F);
  EXPECT_LT(dark->patterns[0].intensity->at(63, 55), 0.3F);
  EXPECT_EQ(sent(bench.begin(kWindow)), light);
  bench.go_dark();
  EXPECT_EQ(sent(bench.begin(kWindow))->patterns[0].intensity->pixels,
            dark->patterns[0].intensity->pixels);
  worker = {};  // nobody computes the light of another window
  EXPECT_FALSE(scene(bench.begin({0, 0, 64, 64}), nullptr, milliseconds(0)));
}

TEST_F(RunningBench, AFrameBegunBeforeAChangeMayShowThePreviousImageForAShortTimeOnly) {
  const auto before = sent(bench.begin(kWindow));
  worker = {};  // no far field is ready from now on
  const std::uint64_t begun = bench.begin(kWindow);
  bench.show({picture}, steady_clock::now() + std::chrono::seconds(10));
  EXPECT_EQ(scene(begun, before, milliseconds(0)), before);
  EXPECT_FALSE(scene(bench.begin(kWindow), before, milliseconds(0))) << "begun after the change";
  bench.show({Image<std::uint8_t>(picture.width, picture.height, 7)},
             steady_clock::now() - milliseconds(15));
  EXPECT_FALSE(scene(begun, before, milliseconds(0))) << "the change is too long ago";
}

TEST_F(RunningBench, NoFrameShowsTheOldTruthAfterAnOrder) {
  const auto before = sent(bench.begin(kWindow));
  const std::uint64_t begun = bench.begin(kWindow);
  Truth truth = bench.truth();
  truth.aberration = {{3, 0.3}};
  bench.set_truth(truth);
  show(picture);
  EXPECT_EQ(sent(begun)->truth.aberration, truth.aberration);
  EXPECT_NE(sent(begun), before);
}

TEST_F(RunningBench, SendsFramesWhileTheDisplayChangesFasterThanFarFieldsAreComputed) {
  sent(bench.begin(kWindow));
  const std::jthread changes([this](const std::stop_token& token) {
    Image<std::uint8_t> grey = picture;
    while (!token.stop_requested()) {
      ++grey.pixels.front();
      show(grey);
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  for (int frame = 0; frame < 10; ++frame) {
    const std::uint64_t begun = bench.begin(kWindow);
    Light ready, light;
    while ((light = scene(begun, ready, milliseconds(20'000))) != ready) ready = light;
    ASSERT_TRUE(light) << "frame " << frame;
  }
}

class Frames : public ::testing::Test {
 protected:
  static constexpr int kSize = 64;

  FrameRequest request(Noise noise, float light = 1.0F) {
    auto scene = std::make_shared<Scene>();
    scene->patterns = {{std::make_shared<Image<float>>(kSize, kSize, light)}};
    scene->truth.peak_electrons = 1000.0;
    scene->truth.noise = noise;
    scene->truth.detector.prnu = 0.0;
    scene->truth.detector.black_level_dn = 0.0;
    FrameRequest result;
    result.scene = scene;
    result.exposure_us = kReferenceExposureUs;
    return result;
  }
  std::vector<std::byte> take(const FrameRequest& wanted) {
    std::vector<std::byte> out(frame_bytes(wanted.format, kSize, kSize));
    EXPECT_TRUE(
        source.take(wanted, steady_clock::now() + milliseconds(20'000), stop.get_token(), out));
    return out;
  }

  FrameSource source{632.0};
  std::stop_source stop;
  std::jthread worker{[this](const std::stop_token& s) { source.work(s); }};
};

TEST_F(Frames, AreEachANewRealisation) {
  const FrameRequest wanted = request(Noise::fresh);
  const auto first = take(wanted);
  for (int n = 0; n < 10; ++n) EXPECT_NE(take(wanted), first);
  EXPECT_EQ(source.counts().fresh, 11U);
  EXPECT_EQ(source.counts().reused, 0U);
}

TEST_F(Frames, AreMadeAheadWhileNoneIsTaken) {
  const FrameRequest wanted = request(Noise::fresh);
  std::uint64_t reused = 99;
  // A busy machine takes longer for each.
  for (milliseconds pause(3); reused >= 10 && pause < std::chrono::seconds(1); pause *= 4) {
    reused = -source.counts().reused;
    for (int n = 0; n < 60; ++n, std::this_thread::sleep_for(pause)) take(wanted);
    reused += source.counts().reused;
  }
  EXPECT_LT(reused, 10U);
}

TEST_F(Frames, WithoutNoiseAreTheMeanDigitised) {
  FrameRequest wanted = request(Noise::none);
  EXPECT_EQ(int(take(wanted)[0]), 26);  // 1000 of 10000 electrons, of 255
  wanted.gain_db = 20.0;
  EXPECT_EQ(int(take(wanted)[0]), 255);
  wanted.gain_db = 6.0206;
  EXPECT_EQ(int(take(wanted)[0]), 51);
  wanted.gain_db = 0.0;
  wanted.exposure_us = 500.0;
  EXPECT_EQ(int(take(wanted)[0]), 6);
}

TEST_F(Frames, OfTwelveBitsAreLittleEndianAndRightJustified) {
  FrameRequest wanted = request(Noise::none);
  wanted.format = PixelFormat::mono12;
  std::uint16_t value = 0;
  std::memcpy(&value, take(wanted).data(), 2);
  EXPECT_EQ(value, 410);  // 1000 of 10000 electrons, of 4095: 409.5
}

TEST_F(Frames, OfAPoolComeRoundAgain) {
  const FrameRequest wanted = request(Noise::pool);
  const auto first = take(wanted);
  int again = 0;
  for (int n = 1; n < 64; ++n) again += take(wanted) == first ? 1 : 0;
  EXPECT_EQ(again, 1);
  EXPECT_EQ(source.counts().reused, 0U);
}

TEST_F(Frames, NeverShowTheRequestBefore) {
  const FrameRequest dim = request(Noise::fresh, 0.1F), bright = request(Noise::fresh, 5.0F);
  for (int n = 0; n < 20; ++n) {
    EXPECT_LT(int(take(dim)[0]), 30);
    EXPECT_GT(int(take(bright)[0]), 90);
  }
}

TEST(Faults, LastForTheirFramesAndNoLonger) {
  Faults faults;
  const std::stop_source stop;
  faults.order({FaultKind::drop, 2, 0.0, 0.0});
  EXPECT_EQ(faults.next_frame(stop.get_token()), FrameFate::drop);
  EXPECT_EQ(faults.active().frames, 1);
  EXPECT_EQ(faults.next_frame(stop.get_token()), FrameFate::drop);
  EXPECT_EQ(faults.next_frame(stop.get_token()), FrameFate::send);
  EXPECT_EQ(faults.active().kind, FaultKind::none);
}

TEST(Faults, AFreezeEndsWhenItIsTakenBack) {
  Faults faults;
  const std::stop_source stop;
  faults.order({FaultKind::freeze, 0, 1000.0, 0.0});
  std::jthread later([&faults] {
    std::this_thread::sleep_for(milliseconds(20));
    faults.order({});
  });
  EXPECT_EQ(faults.next_frame(stop.get_token()), FrameFate::send);
}

}  // namespace
}  // namespace ovws::twin
