/// Camera registration: the affine map from slopes to camera pixels, measured with a probe spot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Observation of a probe spot that was shown with a known slope.
struct ProbeSight {
  Vec2 offset_cpp;  ///< from the base subaperture's grating, cycles per SLM pixel
  Vec2 at_px;       ///< position at which the spot was found
};

/// A fixed array as registration.run has found it.
struct FoundArray {
  Lenslets lenslets{};         ///< in use: lit, and inside the pupil; empty: the sensor has an SLM
  int lit = 0;                 ///< lit lenslets in the image
  double magnification = 1.0;  ///< from the array's focal plane to the camera
  double pupil_diameter_px = 0.0;
  int subapertures_across = 0;
  bool plate_fitted = false;  ///< whether the plates of `lenslets` were measured (fit_plate)

  bool empty() const { return lenslets.empty(); }
  /// Puts the lenslets into a sensor.
  void use_in(SensorConfig& sensor) const;
};

/// Whether `next` are the lenslets of `now`, found again. Then: how far the centre of `next` is
/// from that of `now`, along the array's axes. Noise may move it by a little, and so take in or
/// leave out lenslets at the rim of the pupil.
std::optional<Vec2> shift_if_same(const FoundArray& now, const FoundArray& next);

/// The affine map at = base_px + px_per_cycle * offset.
struct Registration {
  Vec2 base_cpp;  ///< grating of the base subaperture, whose spot is at base_px
  PxPerCycle px_per_cycle;
  Vec2 base_px;
  /// Standard error of each element of px_per_cycle, from the residuals of the fit.
  PxPerCycle standard_error;
  Vec2 base_standard_error_px;
  double residual_px = 0.0;  ///< RMS residual over x and y
  int sights = 0;
  FoundArray array{};
  std::int64_t t_taken_ns = 0;  ///< UNIX epoch UTC; 0: unknown
};

/// Registration with the base moved to another grating, `base_cpp` (cycles per SLM pixel); the
/// affine map is unchanged.
Registration rebased(const Registration& registration, Vec2 base_cpp);

/// Least-squares fit. Errors (Errc::refused): fewer than 4 observations, or all nearly on one line.
Result<Registration> fit_registration(std::span<const ProbeSight> sights);

/// Finds the only spot in `light`: a mean image with the spot minus one without (DN, NaN where
/// unknown). None if no spot stands out of the noise. The spot size in `spots` may be wrong by a
/// third. The position is accurate to a fraction of lambda/d: a start for find_probe.
std::optional<Vec2> spot_in(const Image<float>& light, const SpotModel& spots);

/// A mean image with integer pixels, which trackers read: from its darkest to its brightest pixel,
/// over the full scale of 16 bits. Pixels that are not finite are the brightest.
Image<std::uint16_t> in_16_bits(const Image<float>& light);

/// Probe spot position with the precision of PositionFit, which starts at `start_px` (camera
/// pixels). None if PositionFit does not find the spot.
std::optional<Vec2> find_probe(const Image<float>& light, const SpotModel& spots, Vec2 start_px);

}  // namespace ovws
