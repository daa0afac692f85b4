#include "core/optics/geometry.hpp"

namespace ovws {

PxPerCycle px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm) {
  if (optics.registered) return *optics.registered;
  // lambda f M / (p_slm p_cam), all in micrometres: nm * 1e-3 * mm * 1e3.
  return optics.wavelength_nm * optics.focal_length_mm * optics.magnification /
         (slm.pitch_um * optics.camera_pitch_um);
}

LensletShape filling_shape(Grid grid) {
  return grid == Grid::square ? LensletShape::square : LensletShape::hexagon;
}

bool fits_into(Grid grid, LensletShape shape) {
  return shape == LensletShape::circle || shape == filling_shape(grid);
}

bool is_right_angled(const PxPerCycle& map) {
  constexpr double kTolerance = 0.002;
  const double tolerance = kTolerance * map.scale();
  const auto alone = [tolerance](double one, double other, double zero, double zero_too) {
    return std::abs(zero) < tolerance && std::abs(zero_too) < tolerance &&
           std::abs(std::abs(one) - std::abs(other)) < tolerance;
  };
  return alone(map.xx, map.yy, map.xy, map.yx) || alone(map.xy, map.yx, map.xx, map.yy);
}

bool is_straight(const PxPerCycle& map) {
  return is_right_angled(map) && map.xx > std::abs(map.xy) && map.yy > 0.0;
}

Result<void> check_straight(const OpticsConfig& optics, const SlmGeometry& slm) {
  if (is_straight(px_per_cycle(optics, slm))) return {};
  return fail(
      Errc::refused, "optics.px_per_cycle",
      "the camera is rotated or mirrored relative to the SLM, or its axes differ in scale: align "
      "it with the SLM; the model of studies and images supports no other geometry");
}

double camera_px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm) {
  return px_per_cycle(optics, slm).scale();
}

/// A square of side a has the second moment a^2 / 12 along each axis, a hexagon of width a
/// 5 a^2 / 72, and a circle of diameter a a^2 / 16.
double Lenslets::diameter_px() const {
  switch (shape) {
    case LensletShape::square:
      return width_px * std::sqrt(16.0 / 12.0);
    case LensletShape::hexagon:
      return width_px * std::sqrt(16.0 * 5.0 / 72.0);
    case LensletShape::circle:
      break;
  }
  return width_px;
}

double subaperture_diameter_px(const SensorConfig& sensor) {
  if (!sensor.lenslets.empty()) return sensor.lenslets.diameter_px();
  return sensor.pupil_diameter_px / sensor.subapertures_across;
}

double lambda_d_px(const OpticsConfig& optics, const SlmGeometry& slm, const SensorConfig& sensor) {
  return camera_px_per_cycle(optics, slm) / subaperture_diameter_px(sensor);
}

double camera_shift_mm_per_wave(const OpticsConfig& optics, const SlmGeometry& slm,
                                double pupil_diameter_px) {
  const double wavelength_mm = 1e-6 * optics.wavelength_nm;
  const double diameter_mm = 1e-3 * pupil_diameter_px * slm.pitch_um;
  const double focal_length_mm = camera_px_per_cycle(optics, slm) * 1e-3 * slm.pitch_um * 1e-3 *
                                 optics.camera_pitch_um / wavelength_mm;
  const double f_number = focal_length_mm / diameter_mm;
  return -16.0 * std::sqrt(3.0) * wavelength_mm * f_number * f_number;
}

Vec2 base_spot_px(const OpticsConfig& optics, int image_cols, int image_rows) {
  return optics.centre_px.value_or(Vec2{0.5 * (image_cols - 1), 0.5 * (image_rows - 1)});
}

}  // namespace ovws
