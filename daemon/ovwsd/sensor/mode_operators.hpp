/// Mode operators (matrices between modes and spot displacements), computed from the optics model.
#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "daemon/ovwsd/layout/slope_operator.hpp"

namespace ovws {

/// Appends to `modes_j`, the modes that spot positions determine, the modes up to `mode_count` that
/// only spot shapes determine (tracker `fit` only).
std::vector<int> with_shapes(const TrackingSettings& tracking, std::vector<int> modes_j);

/// Displacements of the spots by each mode about a flat wavefront, computed from the model as
/// SpotMeter measures displacements in mean images: least squares of the pixels that the laser
/// reaches, equally weighted. Errors: those of SpotRenderer::make.
Result<ModeOperator> displacement_operator(const SensorConfig& sensor, const SlmGeometry& slm,
                                           const OpticsConfig& optics, const Roi& roi,
                                           const LitPixels& lit, std::vector<int> modes_j);

/// Everything that a diffractive operator depends on, except the SLM.
struct OperatorKey {
  SensorConfig sensor;
  TrackingSettings tracking;  ///< as position_tracking
  OpticsConfig optics;        ///< as configured, or as registered
  int cols = 0, rows = 0;     ///< size of the camera's image, pixels
  /// Compares the registered part of the optics only: all other optics are fixed for one bench.
  friend bool operator==(const OperatorKey& a, const OperatorKey& b) {
    return a.sensor == b.sensor && a.tracking == b.tracking && a.cols == b.cols &&
           a.rows == b.rows && a.optics.registered == b.optics.registered &&
           a.optics.centre_px == b.optics.centre_px;
  }
};
OperatorKey operator_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                         const OpticsConfig& optics, const Roi& roi);

/// Diffractive operator (see core/wavefront/diffractive_matrix.hpp) of the configured tracker.
/// Do not call in the frame path: it takes 0.3 s for 18 modes of the default bench, and some
/// seconds for 91 spots. Errors: those of the core's diffractive_operator, of make_tracker and of
/// SensorField::make; Errc::unavailable if memory runs out or `limit_s` is exceeded.
Result<ModeOperator> diffractive_operator(const OperatorKey& key, const SlmGeometry& slm,
                                          double limit_s = std::numeric_limits<double>::infinity());

/// Cache of the last diffractive operators, and of failures to compute one. It holds two entries,
/// so that the active sensor's operator is kept when a change of the sensor is refused. Not
/// thread-safe.
class LastOperators {
 public:
  using Made = std::shared_ptr<const Result<ModeOperator>>;
  /// Returns the cached operator, or computes it within kLimitS. If memory or time ran out
  /// (Errc::unavailable), computes it again after kRetryNs.
  Made of(const OperatorKey& key, const SlmGeometry& slm);

 private:
  static constexpr double kLimitS = 10.0;  // the prepare thread counts as hung after 30 s
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
