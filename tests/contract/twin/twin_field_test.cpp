/// Far field of the twin where it is computed in parts: pupil and the rest, light and turbulence.
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>

#include "core/optics/hologram.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/camera_map.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

Image<std::uint8_t> defocused_hologram(double defocus_waves = 0.0) {
  Image<std::uint8_t> grey;
  HologramRenderer::make({})->render(HologramKind::sensor, std::vector<Mode>{{4, defocus_waves}},
                                     grey);
  return grey;
}

/// Hologram with a fine grating beside the pupil.
Image<std::uint8_t> rough_beside_pupil(Image<std::uint8_t> grey) {
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < 200; ++x) grey.at(x, y) = std::uint8_t(64 * ((x + y) % 4));
  }
  return grey;
}

/// Largest difference from the far field of the whole SLM, in units of its peak.
double error_in_air(const Config& config, const Turbulence& air) {
  const Image<std::uint8_t> grey = rough_beside_pupil(defocused_hologram());
  BenchModel model(config);
  model.set_window(kWindow, config.truth.geometry);
  model.set_turbulence(&air, kNow);
  const Image<std::complex<float>>& got = model.field(grey);
  SlmModel slm(config);
  slm.set_turbulence(&air, kNow);
  Image<std::complex<float>> light(1280, 768), want;
  slm.modulate(grey, 0, 768, light);
  const CameraView view(camera_map(config, config.truth.geometry), config.slm.geometry, kWindow);
  FarField(config.slm.geometry, view.grid()).propagate(light, want);
  double peak = 0.0, error = 0.0;
  for (std::size_t i = 0; i < want.pixels.size(); ++i) {
    peak = std::max(peak, double(std::abs(want.pixels[i])));
    error = std::max(error, double(std::abs(got.pixels[i] - want.pixels[i])));
  }
  return error / peak;
}

TEST(BenchModel, TurbulenceActsOnTheFieldOfThePupil) {
  // The two interpolate the turbulence between other points.
  EXPECT_LT(error_in_air(config_of(), Turbulence({.rms_waves = 0.1})), 3e-4);
  EXPECT_LT(error_in_air(config_of(), Turbulence({.rms_waves = 0.5, .seed = 3})), 1e-3);
  EXPECT_LT(error_in_air(config_of(R"({"light": {"diameter_px": 450}})"), Turbulence({})), 3e-4);
}

TEST(BenchModel, WhatWasSeenBeforeLeavesNoTrace) {
  const Turbulence air({.rms_waves = 0.2});
  const std::vector<Mode> defocus{{4, 0.1}};
  const std::vector<Shade> shade{{{300.0, 300.0}, 90.0, 0.5}};
  const Roi elsewhere{64, 32, 256, 384};
  const Image<std::uint8_t> flat = defocused_hologram(), bent = defocused_hologram(0.3);
  BenchModel used(config_of());
  // Compares with a model that has seen nothing else.
  const auto check = [&](const Image<std::uint8_t>& grey, const Roi& window, bool lit,
                         const Turbulence* turbulence, const char* step) {
    BenchModel fresh(config_of());
    if (lit) fresh.set_light({defocus, shade});
    fresh.set_window(window, {});
    fresh.set_turbulence(turbulence, kNow);
    EXPECT_EQ(used.intensity(grey).pixels, fresh.intensity(grey).pixels) << step;
  };
  used.set_window(kWindow, {});
  check(flat, kWindow, false, nullptr, "first");
  check(bent, kWindow, false, nullptr, "other hologram");
  check(rough_beside_pupil(bent), kWindow, false, nullptr, "other light beside the pupil");
  used.set_turbulence(&air, kNow);
  check(flat, kWindow, false, &air, "turbulence");
  used.set_light({defocus, shade});
  check(flat, kWindow, true, &air, "other light");
  used.set_window(elsewhere, {});
  check(flat, elsewhere, true, &air, "other window");
  used.set_turbulence(nullptr, 0);
  check(flat, elsewhere, true, nullptr, "no turbulence");
}

}  // namespace
}  // namespace ovws::twin
