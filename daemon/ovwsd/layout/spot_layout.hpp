/// Geometric checks of the spot layout: whether the camera sees the spots and whether the tracker
/// can separate neighbouring spots.
#pragma once

#include <limits>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Minimum distance of neighbouring spots, in lambda/d, at which the tracker finds all spots of a
/// flat wavefront. In units of the radius of the spot's first dark ring (spot_geometry): 0.93 for
/// charge 1, 1.05 for charges 2 and 3, 1.35 for higher charges, 1.5 for bright spots. Measured with
/// `ovws farfield` and the twin, for 5 and 7 subapertures across and charges 0 to 7: just below
/// this distance, some or all spots are lost.
double min_spot_distance(int charge);

/// Recommended distance of neighbouring spots, in lambda/d: 1.6 radii of the spot's first dark
/// ring. It leaves room for aberrations.
double recommended_spot_distance(int charge);

/// Least distance of a spot from the SLM's zeroth order, in lambda/d, at which the zeroth order's
/// side orders do not disturb the measurement. The light between the subapertures is not
/// diffracted: its far field has peaks around the zeroth order whose intensity, relative to a
/// spot's, is proportional to the square of the number of subapertures and falls with the third
/// power of the distance.
double min_zeroth_distance(std::size_t subapertures, int charge);

/// Everything that determines where the spots fall on the camera. Holds references to the caller's
/// objects.
struct SpotBench {
  const Lattice& lattice;
  const SensorConfig& sensor;
  const TrackingSettings& tracking;
  const OpticsConfig& optics;
  const SlmGeometry& slm;
  const Roi& roi;
  PixelFormat format;
};

/// The spots' bench by the configuration. `lattice`: that of the configuration; it must outlive the
/// result, and so must `config`.
SpotBench spot_bench(const Config& config, const Lattice& lattice);

/// Layout of the spots of a flat wavefront on the camera.
struct SpotLayout {
  std::vector<Vec2> spots_px;
  double lambda_d_px = 0.0;
  double nearest = std::numeric_limits<double>::infinity();  ///< closest two spots, lambda/d
  Vec2 reach_px;           ///< largest distance of a spot from the base spot, in x and in y
  double margin_px = 0.0;  ///< recommended distance of a spot's centre from the image's edge
};

SpotLayout spot_layout(const SpotBench& bench);

/// Sizes of a camera's region are multiples of this number of pixels: every camera accepts them.
constexpr int kRegionStep = 16;

/// Size in pixels of the smallest region, centred on the base spot, that contains all spots with
/// their margin after their distances from the base spot are multiplied by `factor`.
Vec2 region_for(const SpotLayout& layout, double factor);

/// Distance of the base spot from the SLM's zeroth order, camera pixels.
Vec2 zeroth_order_px(const SpotBench& bench);

/// Whether a region of this size, centred on the base spot, contains the zeroth order, which is
/// much brighter than the spots.
bool contains_zeroth_order(Vec2 region, const SpotBench& bench);

/// Checks that the zeroth order is outside the camera's region, by lambda/d at least, and not
/// nearer to a spot than min_zeroth_distance. Errc::invalid, field "camera.roi" or
/// "sensor.grooves": it is not; the message proposes values that work.
Result<void> check_zeroth_order(const SpotBench& bench);

/// Rounds to two significant digits, for proposed settings.
double rounded_up(double value);
double rounded_down(double value);

/// Checks the distance of neighbouring spots. Errc::invalid, field "sensor.spacing": it is less
/// than min_spot_distance. The message proposes values that work.
Result<void> check_spots_apart(const SpotBench& bench);

/// Checks that the tracker finds all spots of a flat wavefront behind the mask, or of charges that
/// differ in size, near their places. Errc::invalid, field "sensor.mask",
/// "sensor.alternate_charge" or "sensor.charges": it does not; or those of make_tracker. Renders
/// the spots, some 20 ms, if there is a mask or if the charges differ in size.
Result<void> check_spots_found(const SpotBench& bench);

/// Checks the requested number of modes. Errc::invalid, field "tracking.mode_count": it is more
/// than the spots determine, or less than positions determine. The message says how many modes are
/// possible, with which error. Renders the spots, which is slow, if more modes are requested than
/// positions determine.
Result<void> check_mode_count(const SpotBench& bench);

/// Checks that the camera's region contains enough spots. Errc::invalid, field "camera.roi": the
/// spots that lie completely inside the region do not determine the modes. The message proposes
/// values that work.
Result<void> check_spots_in_region(const SpotBench& bench);

}  // namespace ovws
