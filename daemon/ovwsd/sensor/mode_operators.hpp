/// Mode operators (matrices between modes and spot displacements) of the model.
#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// OSA indices of the modes to reconstruct: 1 .. Z_opt (paper eq. 5). The lattice may determine
/// fewer.
std::vector<int> reconstructed_modes(const SensorConfig& sensor);

/// These modes, which positions determine, and those up to `mode_count` that only shapes determine.
std::vector<int> with_shapes(const TrackingSettings& tracking, std::vector<int> modes_j);

/// Slope operator: the tilt of each mode over each subaperture, as the tracker weights it. Contains
/// only modes that the lattice determines. Fast.
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map);
/// The same for a ring of this radius (slope_model.hpp).
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor, double tilt_radius,
                            const PxPerCycle& map);

/// How far the spots of a flat wavefront move by the model, as SpotMeter measures it in mean
/// images: by least squares of their pixels, all weighed the same. Errors: those of
/// SpotRenderer::make.
Result<ModeOperator> displacement_operator(const SensorConfig& sensor, const SlmGeometry& slm,
                                           const OpticsConfig& optics, const Roi& roi,
                                           std::vector<int> modes_j);

/// Everything that a diffractive operator depends on, except the SLM.
struct OperatorKey {
  SensorConfig sensor;
  TrackingSettings tracking;  ///< normalised by reference_key
  OpticsConfig optics;        ///< as configured, or as registered
  int cols = 0, rows = 0;     ///< of the camera's image
  /// Compares the registered part of the optics only: the rest is fixed for one bench.
  friend bool operator==(const OperatorKey& a, const OperatorKey& b) {
    return a.sensor == b.sensor && a.tracking == b.tracking && a.cols == b.cols &&
           a.rows == b.rows && a.optics.registered == b.optics.registered &&
           a.optics.centre_px == b.optics.centre_px;
  }
};
OperatorKey operator_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                         const OpticsConfig& optics, const Roi& roi);

/// Diffractive operator (see core/wavefront/diffractive_matrix.hpp) of the configured tracker.
/// Takes 0.3 s for 18 modes of the default bench, some seconds for 91 spots: not for the frame
/// path. Errors: those of the core's function, of make_tracker and of SensorField::make;
/// Errc::unavailable if memory runs out.
Result<ModeOperator> diffractive_operator(const OperatorKey& key, const SlmGeometry& slm,
                                          double limit_s = std::numeric_limits<double>::infinity());

/// The last diffractive operators, or why there is none: that of the active sensor is still there
/// after a change that was refused. One thread at a time.
class LastOperators {
 public:
  using Made = std::shared_ptr<const Result<ModeOperator>>;
  /// Makes it unless it is one of the last, and gives up after kLimitS. A failure for want of
  /// memory or time (Errc::unavailable) is tried again after kRetryNs.
  Made of(const OperatorKey& key, const SlmGeometry& slm);

 private:
  static constexpr double kLimitS = 10.0;  // of the prepare thread's 30 s
  static constexpr std::int64_t kRetryNs = 60'000'000'000;
  static constexpr std::size_t kCapacity = 2;
  struct Entry {
    OperatorKey key;
    Made made;
    std::int64_t t_made_ns = 0;
  };
  std::deque<Entry> last_;  ///< newest first
};

}  // namespace ovws
