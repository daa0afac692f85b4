/// Configuration of a fixed lenslet array with a spiral phase plate in each lenslet.
#pragma once

#include <optional>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "proto/reader.hpp"

namespace ovws::twin {

/// Errors of manufacture of the spiral phase plates. The phase at the angle theta around the
/// spiral's axis is depth * charge * theta, theta = 0 … 2 pi from +x towards +y. With steps, theta
/// is that of the middle of its step.
struct PlateConfig {
  int levels = 0;      ///< steps per turn; 0: smooth
  double depth = 1.0;  ///< 1.05: 5 % too deep
  Vec2 shift_um{};     ///< of the spiral's axis from the lenslet's centre

  friend bool operator==(const PlateConfig&, const PlateConfig&) = default;
};

struct ArrayConfig {
  double pitch_um = 150.0;
  Grid lattice = Grid::square;
  /// Squares fill a square lattice, hexagons a hexagonal one; none: the one of the two that does.
  /// Circles have the pitch as their diameter; what is between them is opaque.
  std::optional<LensletShape> shape{};
  int columns = 47, rows = 35;
  /// Diameter of the circle over which the aberration is defined; none: pupil_um's default.
  std::optional<double> pupil_mm{};
  PlateConfig plate{};
  /// Diameter of the beam (1/e^2 for LightShape::gaussian), centred on the array; none: uniform.
  std::optional<double> beam_diameter_mm{};
  /// How far from its centre the field of a lenslet is computed, along x and y of the camera.
  double reach_pitches = 1.5;

  friend bool operator==(const ArrayConfig&, const ArrayConfig&) = default;
};

/// Diameter of the aberration's pupil: by default the largest circle inside the array.
double pupil_um(const ArrayConfig& array);
LensletShape shape_of(const ArrayConfig& array);
/// Distance between rows.
double row_um(const ArrayConfig& array);

/// Half of the width of the box of camera pixels that a lenslet's field is computed in, without the
/// middle pixel.
int reach_px(const ArrayConfig& array, double px_per_um);
/// Number of samples across a lenslet that its field is computed from.
int samples_across(const ArrayConfig& array, const OpticsConfig& optics);

/// Reads the section `array` of the configuration.
void read_array(ObjectReader& reader, ArrayConfig& array);
/// Checks that this array can be simulated. Errors: Errc::invalid, field "array.…".
Result<void> check_array(const ArrayConfig& array, const OpticsConfig& optics,
                         double magnification);

}  // namespace ovws::twin
