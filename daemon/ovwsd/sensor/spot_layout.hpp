/// Whether the camera can see the sensor's spots and a tracker tell them apart, by geometry alone.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Distance of neighbouring spots in lambda/d from which the tracker finds them in a flat
/// wavefront. In units of the radius of the spot's first dark ring (spot_geometry): `matched`,
/// whose template covers all within that ring, 1.48; others 0.93 for charge 1, 1.05 for 2 and 3,
/// 1.35 for higher ones, and 1.5 for bright spots. Measured with `ovws farfield` and the twin, 5
/// and 7 subapertures across, charges 0 to 7: just below nothing or a part is found.
double least_spot_distance(int charge, TrackerKind tracker);

/// The same with room for aberrations, 1.6 such radii: all spots are found, and the modes are
/// valid.
double good_spot_distance(int charge);

/// All of a bench that says where its spots fall. Borrowed.
struct SpotBench {
  const Lattice& lattice;
  const SensorConfig& sensor;
  const TrackingConfig& tracking;
  const OpticsConfig& optics;
  const SlmGeometry& slm;
  const Roi& roi;
};

/// Errc::invalid, field "sensor.spacing": neighbouring spots are closer than least_spot_distance.
/// The reason names values that work.
Result<void> check_spots_apart(const SpotBench& bench);

/// Errc::invalid, field "camera.roi": so many spots fall outside the camera's region, or across its
/// edge, that the others do not determine the modes. The reason names values that work.
Result<void> check_spots_in_region(const SpotBench& bench);

}  // namespace ovws
