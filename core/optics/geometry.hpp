/// The bench in numbers: SLM, lens and camera, and the sensor shown on the SLM.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

struct SlmGeometry {
  int width_px = 1280;
  int height_px = 768;
  double pitch_um = 19.0;
};

/// Camera pixels that a spot moves per cycle-per-SLM-pixel of slope (u, v), x right and y down on
/// both: (xx u + xy v, yx u + yy v).
struct PxPerCycle {
  double xx = 0.0, xy = 0.0, yx = 0.0, yy = 0.0;

  constexpr PxPerCycle() = default;
  /// A camera whose axes are those of the SLM.
  constexpr PxPerCycle(double scale)  // NOLINT(google-explicit-constructor): a scale is a matrix
      : xx(scale), yy(scale) {}
  constexpr PxPerCycle(double xx_, double xy_, double yx_, double yy_)
      : xx(xx_), xy(xy_), yx(yx_), yy(yy_) {}

  Vec2 operator*(Vec2 cpp) const { return {xx * cpp.x + xy * cpp.y, yx * cpp.x + yy * cpp.y}; }
  /// (1 / scale()) times the transpose: for a camera that only turns and mirrors, the SLM's
  /// direction that it sees as `camera`.
  Vec2 back(Vec2 camera) const {
    const double s = scale();
    return {(xx * camera.x + yx * camera.y) / s, (xy * camera.x + yy * camera.y) / s};
  }
  PxPerCycle operator/(double divisor) const {
    return {xx / divisor, xy / divisor, yx / divisor, yy / divisor};
  }
  double determinant() const { return xx * yy - xy * yx; }
  /// Of an area's side: the geometric mean of both directions.
  double scale() const { return std::sqrt(std::abs(determinant())); }
  bool mirrored() const { return determinant() < 0.0; }
  /// By how much the camera turns the SLM's +x towards its own +y.
  double rotation_deg() const { return std::atan2(yx, xx) * 180.0 / std::numbers::pi; }
  friend bool operator==(const PxPerCycle&, const PxPerCycle&) = default;
};

struct OpticsConfig {
  double wavelength_nm = 632.0;
  double focal_length_mm = 200.0;
  double magnification = 1.0;
  double camera_pitch_um = 3.45;
  /// Camera pixel of the base subaperture's spot, in the ROI; none: the centre of the image.
  std::optional<Vec2> centre_px;
  /// As a registration measured it; none: S of focal length, magnification and pitches, without
  /// rotation.
  std::optional<PxPerCycle> registered = std::nullopt;
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

/// `registered`, or S = lambda f M / (p_slm p_cam) in both directions.
PxPerCycle px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm);

/// Whether the camera's axes are so nearly the SLM's that models along its axes hold: to 0.002 of
/// the scale, half a pixel at 250 pixels.
bool is_straight(const PxPerCycle& map);
/// Errc::refused for a camera that is not.
Result<void> check_straight(const OpticsConfig& optics, const SlmGeometry& slm);

/// Its scale alone: camera pixels that a spot moves per cycle-per-SLM-pixel of slope.
double camera_px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm);

/// lambda/d on the camera, in camera pixels: the size of one subaperture's diffraction spot.
double lambda_d_px(const OpticsConfig& optics, const SlmGeometry& slm, const SensorConfig& sensor);

/// Where the base subaperture's spot falls in an image of this size: centre_px, or ((cols-1)/2,
/// (rows-1)/2).
Vec2 base_spot_px(const OpticsConfig& optics, int image_cols, int image_rows);

}  // namespace ovws
