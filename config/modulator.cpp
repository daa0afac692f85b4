/// Completes the configuration of a sensor whose subapertures no SLM makes.
#include <algorithm>
#include <cmath>
#include <utility>

#include "config/config.hpp"

namespace ovws {
namespace {

constexpr const char* kNoDisplay = "none";
constexpr int kNoPixels = 16;  // size of the image that is never shown

/// Places of a centred lattice without rotation whose cells lie inside the pupil.
std::vector<Vec2> centred_lattice(Grid grid, double pitch_px, double pupil_px) {
  constexpr double kMostRows = 200.0;
  const bool hexagonal = grid == Grid::hexagonal;
  const double row_px = pitch_px * (hexagonal ? std::sqrt(0.75) : 1.0);
  const double reach_px = 0.5 * (pupil_px - pitch_px) * (1.0 + 1e-9);
  const int most = int(std::clamp(reach_px / row_px, 0.0, kMostRows));
  std::vector<Vec2> places;
  for (int b = -most; b <= most; ++b) {
    for (int a = -most - 1; a <= most + 1; ++a) {
      const Vec2 at{(a + (hexagonal && b % 2 != 0 ? 0.5 : 0.0)) * pitch_px, b * row_px};
      if (norm(at) <= reach_px) places.push_back(at);
    }
  }
  return places;
}

}  // namespace

double lenslet_pitch_px(const ArrayConfig& array, const OpticsConfig& optics) {
  return array.pitch_um * optics.magnification / optics.camera_pitch_um;
}

double magnification_of(const Config& config, double pitch_px) {
  return pitch_px * config.optics.camera_pitch_um / config.array.pitch_um;
}

SensorConfig sensor_with(const Config& config, ArrayOnCamera lenslets) {
  const OpticsConfig& optics = config.optics;
  const ArrayConfig& array = config.array;
  // Size of a camera pixel on the array.
  const double pixel_um = array.pitch_um / lenslets.pitch_px;
  SensorConfig out = config.sensor;
  out.pupil_diameter_px = lenslets.pupil_diameter_px;
  out.subapertures_across = std::max(1, int(lenslets.pupil_diameter_px / lenslets.pitch_px + 1e-6));
  out.grooves = {0.0, 0.0};
  out.lenslets = {array.shape.value_or(filling_shape(out.grid)),
                  lenslets.pitch_px,
                  lenslets.rotation_deg,
                  {array.plate.levels, array.plate.depth, (1.0 / pixel_um) * array.plate.shift_um},
                  optics.wavelength_nm * optics.focal_length_mm / (pixel_um * pixel_um),
                  std::move(lenslets.centres_px)};
  return out;
}

void use_modulator(Config& config) {
  if (config.modulator != Modulator::fixed) return;
  OpticsConfig& optics = config.optics;
  config.slm.driver = kNoDisplay;
  config.slm.settle_ms = 0.0;
  config.slm.lut.reset();
  config.slm.flatness.reset();
  config.slm.geometry = {kNoPixels, kNoPixels, optics.camera_pitch_um / optics.magnification};
  if (const auto given = std::exchange(optics.registered, std::nullopt)) {
    // Its scale would stretch the lattice, whose pitch on the camera is known.
    optics.registered = given->scaled_to(px_per_cycle(optics, config.slm.geometry).scale());
  }
  if (!config.sensor.lenslets.empty()) return;
  const Roi& roi = config.camera.settings.roi;
  const double pitch_px = lenslet_pitch_px(config.array, optics);
  const double px_per_mm = 1e3 * pitch_px / config.array.pitch_um;
  const double diameter_px = config.array.pupil_mm ? px_per_mm * *config.array.pupil_mm
                                                   : double(std::min(roi.width, roi.height));
  config.sensor = sensor_with(config, {pitch_px, 0.0, diameter_px,
                                       centred_lattice(config.sensor.grid, pitch_px, diameter_px)});
}

}  // namespace ovws
