/// Wavefront over the whole pupil from images of one vortex whose axis is moved over it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/pixel_format.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// The beam of a vortex that fills the pupil, as the camera sees it.
struct VortexBeam {
  PxPerCycle px_per_cycle;         ///< camera pixels per cycle per SLM pixel
  double pupil_diameter_px = 0.0;  ///< SLM pixels
  int charge = 1;                  ///< of the vortex: +1 or -1
  LitPixels lit{};                 ///< camera pixels that receive the light

  /// lambda/D, the diffraction scale of the whole pupil, camera pixels.
  double lambda_d_px() const { return px_per_cycle.scale() / pupil_diameter_px; }
};

/// Image of the vortex with its axis at one place of the pupil.
struct VortexImage {
  Vec2 axis;           ///< place of the axis, pupil radii: x right, y down
  Image<float> light;  ///< DN without the background; NaN where unknown
};

/// Result of fit_vortex_path.
struct VortexPath {
  std::vector<Mode> modes;             ///< RMS-normalised, without tilts: j = 3, 4, …
  std::vector<double> standard_error;  ///< of each mode, waves, from the residual of the fit
  Vec2 middle_px;                      ///< position of a beam without a vortex, camera pixels
  /// Position of the dark core in each image, camera pixels, without the beam's motion from image
  /// to image. None: no zero near the beam.
  std::vector<std::optional<Vec2>> cores_px;
  double motion_px = 0.0;  ///< RMS motion of the beam from image to image
  double residual = 0.0;   ///< RMS of the pixels' residuals, relative to the brightest pixel
};

/// Places of the axis that determine the modes: the middle and a ring.
std::vector<Vec2> vortex_axes();

/// Half-width of the window that is fitted, unit: lambda/D.
constexpr double kVortexWindow = 3.0;

/// Gauss-Newton fit (Levenberg-Marquardt) of the far field |U|^2 to all pixels within kVortexWindow
/// of `start_px`, where the beam is expected within 0.5 lambda/D. U(k) is the exact Fourier
/// integral over the pupil of the vortex, the modes and an uneven amplitude. Its zero is the dark
/// core. A core that is on the axis in the pupil stays in the middle; off the axis it moves
/// perpendicular to the shift in focus, and defocus turns its path (Korzeniewska et al.,
/// arXiv:2504.08643). The result is accurate while the wavefront is within 0.15 wave RMS: show the
/// opposite of a stronger one. Amplitude, background and tilt of each image are free: a beam that
/// moves between the images, by up to 0.5 lambda/D, does not mislead the modes. Errors
/// (Errc::refused): an image has too few pixels in the window, or the fit does not converge.
Result<VortexPath> fit_vortex_path(std::span<const VortexImage> images, const VortexBeam& beam,
                                   Vec2 start_px);

}  // namespace ovws
