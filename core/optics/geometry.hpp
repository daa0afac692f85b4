/// The bench in numbers: SLM, lens and camera, and the sensor shown on the SLM.
#pragma once

#include <array>
#include <optional>

#include "core/base/vec2.hpp"

namespace ovws {

struct SlmGeometry {
  int width_px = 1280;
  int height_px = 768;
  double pitch_um = 19.0;
};

struct OpticsConfig {
  double wavelength_nm = 632.0;
  double focal_length_mm = 200.0;
  double magnification = 1.0;
  double camera_pitch_um = 3.45;
  /// Camera pixel of the base subaperture's spot, in the ROI; none: the centre of the image.
  std::optional<Vec2> centre_px;
};

enum class Grid { hexagonal, square };

/// The sensor's hologram (paper eq. 1 to 4). Defaults are the paper's bench; charge 0 is the
/// conventional Shack-Hartmann sensor.
struct SensorConfig {
  int charge = 1;
  Grid grid = Grid::hexagonal;
  int subapertures_across = 5;
  double pupil_diameter_px = 768.0;
  std::array<double, 2> grooves{200.0, 20.0};
  double spacing = 0.25;

  friend bool operator==(const SensorConfig&, const SensorConfig&) = default;
};

/// S = lambda f M / (p_slm p_cam): camera pixels that a spot moves per cycle-per-SLM-pixel of
/// slope.
double camera_px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm);

/// lambda/d on the camera, in camera pixels: the size of one subaperture's diffraction spot.
double lambda_d_px(const OpticsConfig& optics, const SlmGeometry& slm, const SensorConfig& sensor);

/// Where the base subaperture's spot falls in an image of this size: centre_px, or ((cols-1)/2,
/// (rows-1)/2).
Vec2 base_spot_px(const OpticsConfig& optics, int image_cols, int image_rows);

}  // namespace ovws
