/// Mode operators (matrices between modes and spot displacements): computing and caching them.
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

/// OSA indices of the modes to reconstruct: 1 .. Z_opt (paper eq. 5). The lattice may determine
/// fewer.
std::vector<int> reconstructed_modes(const SensorConfig& sensor);

/// These modes, which positions tell, and those up to `mode_count` that only shapes tell.
std::vector<int> with_shapes(const TrackingSettings& tracking, std::vector<int> modes_j);

/// Slope operator: the tilt of each mode over each subaperture, as the tracker weights it. Contains
/// only modes that the lattice determines. Fast.
ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map);

/// How far the spots of a flat wavefront move by the model, as SpotMeter measures it in mean
/// images: by least squares of their pixels, all weighed the same. Errors: those of
/// SpotRenderer::make.
Result<ModeOperator> displacement_operator(const SensorConfig& sensor, const SlmGeometry& slm,
                                           const OpticsConfig& optics, const Roi& roi,
                                           std::vector<int> modes_j);

/// Everything that a diffractive operator depends on, except the SLM. Cache key.
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

/// Diffractive operator: pokes each mode in the diffraction model and tracks the spots with the
/// configured tracker (see diffractive_matrix). Templates of a reference are made from the model's
/// flat image. Takes seconds, many for large lattices: not for the frame path. Errors: those of
/// diffractive_matrix and of SensorModel::make; Errc::refused, field "tracking", if it determines
/// fewer modes than the slopes; Errc::unavailable if memory runs out.
Result<ModeOperator> diffractive_operator(const OperatorKey& key, const SlmGeometry& slm,
                                          const std::atomic<bool>* stop = nullptr);

/// Cache of diffractive operators and of the errors of failed attempts. One thread at a time.
class OperatorCache {
 public:
  using Made = std::shared_ptr<const Result<ModeOperator>>;
  /// Null: not in the cache.
  Made find(const OperatorKey& key) const;
  void put(const OperatorKey& key, Result<ModeOperator> made);
  /// Discards attempts that ran out of memory (Errc::unavailable), so that they can be repeated;
  /// keeps that of `except`, if it is not null.
  void forget_shortages(const OperatorKey* except);

 private:
  static constexpr std::size_t kCapacity = 8;      // operators, up to some MiB each
  std::deque<std::pair<OperatorKey, Made>> made_;  ///< oldest first
};

}  // namespace ovws
