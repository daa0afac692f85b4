/// Geometry of the bench: SLM, lens, camera, and the sensor's hologram.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/mask.hpp"

namespace ovws {

struct SlmGeometry {
  int width_px = 1280;
  int height_px = 768;
  double pitch_um = 19.0;
};

/// Registration matrix (2 x 2) from spatial frequency on the SLM to camera pixels. A slope (u, v)
/// in cycles per SLM pixel moves a spot by (xx u + xy v, yx u + yy v). On SLM and camera, x points
/// right and y down.
struct PxPerCycle {
  double xx = 0.0, xy = 0.0, yx = 0.0, yy = 0.0;

  constexpr PxPerCycle() = default;
  /// A camera aligned with the SLM: `scale` times the identity.
  constexpr PxPerCycle(double scale)  // NOLINT(google-explicit-constructor): a scale is a matrix
      : xx(scale), yy(scale) {}
  constexpr PxPerCycle(double xx_, double xy_, double yx_, double yy_)
      : xx(xx_), xy(xy_), yx(yx_), yy(yy_) {}

  Vec2 operator*(Vec2 cpp) const { return {xx * cpp.x + xy * cpp.y, yx * cpp.x + yy * cpp.y}; }
  /// Converts a direction in the camera image to the SLM: transpose / scale(), times `camera`.
  /// Exact for a rotation or reflection with equal scale in x and y.
  Vec2 back(Vec2 camera) const {
    const double s = scale();
    return {(xx * camera.x + yx * camera.y) / s, (xy * camera.x + yy * camera.y) / s};
  }
  /// Converts a position on the SLM to the camera's axes, still in SLM pixels. Inverse of back().
  Vec2 seen(Vec2 slm) const {
    const double s = scale(), d = determinant();
    return {s * (yy * slm.x - yx * slm.y) / d, s * (xx * slm.y - xy * slm.x) / d};
  }
  PxPerCycle operator/(double divisor) const {
    return {xx / divisor, xy / divisor, yx / divisor, yy / divisor};
  }
  /// The same rotation and reflection with this mean scale.
  PxPerCycle scaled_to(double to) const {
    const double s = scale();
    return {xx / s * to, xy / s * to, yx / s * to, yy / s * to};
  }
  double determinant() const { return xx * yy - xy * yx; }
  /// Mean scale, camera pixels per (cycle per SLM pixel): sqrt |determinant|.
  double scale() const { return std::sqrt(std::abs(determinant())); }
  bool mirrored() const { return determinant() < 0.0; }
  /// Rotation of the camera image: angle from the camera's +x to the image of the SLM's +x,
  /// positive towards the camera's +y.
  double rotation_deg() const { return std::atan2(yx, xx) * 180.0 / std::numbers::pi; }
  friend bool operator==(const PxPerCycle&, const PxPerCycle&) = default;
};

struct OpticsConfig {
  double wavelength_nm = 632.0;
  double focal_length_mm = 200.0;
  double magnification = 1.0;
  double camera_pitch_um = 3.45;
  /// Position in the ROI of the base subaperture's spot (the subaperture at the pupil's centre, see
  /// make_lattice), camera pixels. If none: the image centre.
  std::optional<Vec2> centre_px;
  /// Measured registration. If none, px_per_cycle() computes the scale S from wavelength, focal
  /// length, magnification and pitches, and assumes no rotation.
  std::optional<PxPerCycle> registered = std::nullopt;
};

enum class Grid { hexagonal, square };

/// Shape of a lenslet, as wide as the pitch. Squares fill a square grid, hexagons a hexagonal one.
enum class LensletShape { square, hexagon, circle };
/// The shape that fills this grid without gaps.
LensletShape filling_shape(Grid grid);
/// Whether lenslets of this shape do not overlap in this grid: the filling shape, or circles.
bool fits_into(Grid grid, LensletShape shape);

/// Spiral phase plate in a lenslet, as it was made. Its phase is 2 pi charge depth floor(n t) / n
/// for n steps, t: turns from the lattice's +x towards +y; without steps 2 pi charge depth t.
struct SpiralPlate {
  int levels = 0;      ///< n, steps of a turn; 0: smooth
  double depth = 1.0;  ///< relative to the design
  /// Of the axis from the lenslet's centre, along the lattice's axes, camera pixels on the array.
  Vec2 shift_px;

  friend bool operator==(const SpiralPlate&, const SpiralPlate&) = default;
};

/// Lenslets of a fixed array that give the sensor's spots. By Fresnel's integral the camera in
/// their focal plane sees the far field of the light on the array, where lenslet i has a grating of
/// the frequency centre_i / px_per_cycle: its spot lies behind its centre. Lengths are camera
/// pixels as they appear on the array (camera pitch / magnification). The array's axes are those
/// that the registration matrix maps to the camera's: the camera's own, unless the matrix mirrors
/// or turns the image (is_right_angled).
struct Lenslets {
  LensletShape shape = LensletShape::square;
  double width_px = 0.0;           ///< of a lenslet: the array's pitch
  double rotation_deg = 0.0;       ///< of the lattice, from the array's +x towards +y
  SpiralPlate plate{};             ///< of the sensor's charge, if that is not 0
  double px_per_cycle = 0.0;       ///< displacement of a spot per slope: lambda f M^2 / pitch^2
  std::vector<Vec2> centres_px{};  ///< from the pupil's centre; empty: no array, but an SLM

  bool empty() const { return centres_px.empty(); }
  /// Diameter of the circle with the second moment of a lenslet. It has the same spot size, and the
  /// same mean slope of a cubic phase, within a few percent.
  double diameter_px() const;

  friend bool operator==(const Lenslets&, const Lenslets&) = default;
};

/// Parameters of the sensor's hologram (paper eq. 1 to 4). Defaults are the paper's bench. Charge 0
/// (bright spots instead of vortices) is the conventional Shack-Hartmann sensor.
struct SensorConfig {
  int charge = 1;
  Grid grid = Grid::hexagonal;
  int subapertures_across = 5;
  double pupil_diameter_px = 768.0;
  std::array<double, 2> grooves{200.0, 20.0};
  double spacing = 0.25;
  /// Charge of every second subaperture (see make_lattice); none: `charge`, as all others.
  std::optional<int> alternate_charge = std::nullopt;
  /// Charge of each subaperture, in the order of make_lattice; empty: by the two above.
  std::vector<int> charges{};
  Masks masks{};        ///< phase added in the subapertures
  Lenslets lenslets{};  ///< of a fixed array, in place of the lattice by the values above

  friend bool operator==(const SensorConfig&, const SensorConfig&) = default;
};

/// Registration matrix: optics.registered if measured, otherwise S = lambda f M / (p_slm p_cam)
/// times the identity.
PxPerCycle px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm);

/// Whether the camera is aligned with the SLM: `map` is a positive multiple of the identity to
/// 0.002 of its scale (half a pixel at 250 pixels). SensorModel requires an aligned camera.
bool is_straight(const PxPerCycle& map);
/// Whether `map` is a positive multiple of a mirror, a turn by quarters, or both, to the same
/// tolerance. Such a map takes the grid of the camera's pixels to itself.
bool is_right_angled(const PxPerCycle& map);
/// Checks that the camera is aligned (is_straight); if not: Errc::refused, "optics.px_per_cycle".
Result<void> check_straight(const OpticsConfig& optics, const SlmGeometry& slm);

/// Mean scale of the registration: displacement of a spot in camera pixels for a phase slope of one
/// cycle per SLM pixel.
double camera_px_per_cycle(const OpticsConfig& optics, const SlmGeometry& slm);

/// Diameter of a subaperture, SLM pixels: D / M, or that of the lenslets.
double subaperture_diameter_px(const SensorConfig& sensor);

/// lambda/d on the camera, in camera pixels: the size of one subaperture's diffraction spot.
double lambda_d_px(const OpticsConfig& optics, const SlmGeometry& slm, const SensorConfig& sensor);

/// Distance of the camera from the focus, in mm per RMS-normalised wave of defocus (j = 4) over a
/// pupil of this diameter (SLM pixels): -16 sqrt(3) lambda F^2 / D^2. Positive: the camera is
/// behind the focus, farther from the lens. F = S p_slm p_cam / lambda is the focal length times
/// the magnification that the scale S of the registration implies.
///
/// Derivation: a camera at F + z receives, by Fresnel diffraction in the convention exp(i(kz -
/// wt)), the far field of the pupil times exp(i pi r^2 / lambda (1 / (F + z) - 1 / F)), that is of
/// the wavefront W(r) = -z r^2 / (2 lambda F^2) in waves; this is exact for an SLM in the front
/// focal plane. Defocus is sqrt(3) (2 (2r/D)^2 - 1), which grows by 8 sqrt(3) r^2 / D^2. In this
/// convention larger phase is a longer optical path. If the SLM's phase is in fact an advance, the
/// camera is on the other side of the focus, which no intensity in one plane can tell.
double camera_shift_mm_per_wave(const OpticsConfig& optics, const SlmGeometry& slm,
                                double pupil_diameter_px);

/// Position of the base subaperture's spot in an image of this size: centre_px, or the image centre
/// ((cols-1)/2, (rows-1)/2).
Vec2 base_spot_px(const OpticsConfig& optics, int image_cols, int image_rows);

}  // namespace ovws
