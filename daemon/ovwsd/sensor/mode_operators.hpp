/// The matrices that a measurement plan may read modes with: made here, and kept.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// OSA indices that the sensor reconstructs if its lattice tells them: 1 .. Z_opt (paper eq. 5).
std::vector<int> reconstructed_modes(const SensorConfig& sensor);

/// The tracker's own slopes of the modes that the lattice tells. Fast.
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map);

/// All that a diffractive matrix depends on, with one SLM.
struct OperatorKey {
  SensorConfig sensor;
  TrackingSettings tracking;  ///< `templates` as of a tracker that has one
  OpticsConfig optics;        ///< as configured, or as registered
  int cols = 0, rows = 0;     ///< of the camera's image
  /// On one bench only what a registration finds differs of the optics.
  friend bool operator==(const OperatorKey& a, const OperatorKey& b) {
    return a.sensor == b.sensor && a.tracking == b.tracking && a.cols == b.cols &&
           a.rows == b.rows && a.optics.registered == b.optics.registered &&
           a.optics.centre_px == b.optics.centre_px;
  }
};
OperatorKey operator_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                         const OpticsConfig& optics, const Roi& roi);

/// The same modes by diffraction (diffractive_matrix), found by the tracker in use; templates of a
/// reference are taken of the model's own flat image. Seconds, many for large lattices: off the
/// frame path. Errors: as of diffractive_matrix; Errc::refused, field "tracking", if it tells fewer
/// modes than the slopes, or of a camera that is not straight; Errc::unavailable if memory ends.
Result<ModeOperator> diffractive_operator(const OperatorKey& key, const SlmGeometry& slm,
                                          const std::atomic<bool>* stop = nullptr);

/// Made operators, or why they cannot be made. One thread at a time.
class OperatorShelf {
 public:
  using Made = std::shared_ptr<const Result<ModeOperator>>;
  /// Null: never made, or long ago.
  Made find(const OperatorKey& key) const;
  void put(const OperatorKey& key, Result<ModeOperator> made);
  /// Memory that was short once need not be again: forgets what ended with Errc::unavailable,
  /// except for the key `but`, if there is one.
  void forget_shortages(const OperatorKey* but);

 private:
  static constexpr std::size_t kMost = 8;          // up to some MiB each
  std::deque<std::pair<OperatorKey, Made>> made_;  ///< oldest first
};

}  // namespace ovws
