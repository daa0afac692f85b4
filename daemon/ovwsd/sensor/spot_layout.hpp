/// Geometric checks of the spot layout: whether the camera sees the spots and the tracker can
/// separate them.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Minimum distance of neighbouring spots, in lambda/d, at which the tracker finds them all in a
/// flat wavefront. In units of the radius of the spot's first dark ring (spot_geometry): 0.93 for
/// charge 1, 1.05 for charges 2 and 3, 1.35 for higher charges, 1.5 for bright spots. Measured with
/// `ovws farfield` and the twin, 5 and 7 subapertures across, charges 0 to 7: just below the
/// minimum, some or all spots are lost.
double min_spot_distance(int charge);

/// Recommended distance of neighbouring spots, in lambda/d: 1.6 such radii. It leaves room for
/// aberrations.
double recommended_spot_distance(int charge);

/// Everything that determines where the spots fall. Holds references to the caller's objects.
struct SpotBench {
  const Lattice& lattice;
  const SensorConfig& sensor;
  const TrackingSettings& tracking;
  const OpticsConfig& optics;
  const SlmGeometry& slm;
  const Roi& roi;
  PixelFormat format = PixelFormat::mono8;
};

/// Errc::invalid, field "sensor.spacing": neighbouring spots are closer than min_spot_distance.
/// The message proposes values that work.
Result<void> check_spots_apart(const SpotBench& bench);

/// Errc::invalid, field "tracking.mode_count": the spots do not determine as many modes as
/// requested, or fewer are requested than positions determine, or more with a colour camera. The
/// message says how many are possible, with which error. Renders the spots if more are requested
/// than positions determine.
Result<void> check_mode_count(const SpotBench& bench);

/// Errc::invalid, field "camera.roi": so many spots fall outside the camera's region, or across its
/// edge, that the others do not determine the modes. The message proposes values that work.
Result<void> check_spots_in_region(const SpotBench& bench);

}  // namespace ovws
