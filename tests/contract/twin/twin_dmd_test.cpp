/// The twin's DMD: the far field of a binary hologram against that of an SLM.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/optics/hologram.hpp"
#include "drivers/twin/bench_model.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

/// Camera image of the default bench with an SLM or a DMD, each with its own hologram.
Image<float> seen(Modulator modulator) {
  Config config = parse_config("{}").value();
  config.modulator = modulator;
  HologramConfig hologram;
  if (modulator == Modulator::dmd) hologram.dmd.emplace();
  Image<std::uint8_t> grey;
  HologramRenderer::make(hologram)->render(HologramKind::sensor, {}, grey);
  BenchModel model(config);
  model.set_window(kWindow, config.truth.geometry);
  return model.intensity(grey);
}

TEST(TwinDmd, SpotsOfABinaryHologramAreThoseOfAnSlm) {
  const Image<float> slm = seen(Modulator::slm), dmd = seen(Modulator::dmd);
  const auto sum = [](const Image<float>& a, const Image<float>& b) {
    return std::inner_product(a.pixels.begin(), a.pixels.end(), b.pixels.begin(), 0.0);
  };
  // Mirrors pass half of the light, and the first order has (1 / pi)^2 of it.
  EXPECT_NEAR(sum(slm, dmd) / sum(slm, slm) * std::numbers::pi * std::numbers::pi, 1.0, 0.03);
  EXPECT_GT(sum(slm, dmd) / std::sqrt(sum(slm, slm) * sum(dmd, dmd)), 0.99);
}

TEST(TwinDmd, MirrorsAreOnFromGreyLevel128) {
  Config config = parse_config(R"({"modulator": "dmd"})").value();
  const SlmModel model(config);
  EXPECT_EQ(model.phasor_of_grey()[127], 0.0F);
  EXPECT_EQ(model.phasor_of_grey()[128], 1.0F);
}

TEST(TwinDmd, RefusesAnUnknownModulator) {
  EXPECT_EQ(parse_config(R"({"modulator": "dlp"})").error().field, "modulator");
}

}  // namespace
}  // namespace ovws::twin
