/// The external corrector: a client's matrix from modes to the commands of its actuators.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/rt/latest_value.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/tables/corrector.hpp"

namespace ovws {

/// Largest binary frame of corrector.set and calibration.set, bytes.
constexpr std::size_t kMaxMatrixBytes =
    sizeof(float) * kMaxZernikeIndex *
    std::size_t(std::max(limits::kActuators.max, 2 * limits::kMatrixRows.max));

struct CorrectorMatrix {
  int number = 0;
  int actuators = 0;
  std::int64_t t_set_ns = 0;
  std::vector<int> modes_j;   ///< OSA indices of the columns
  std::vector<float> values;  ///< actuators x modes, by rows
};

/// Multiplies modes by the matrix. It has no state of the loop: the client integrates.
class Corrector {
 public:
  explicit Corrector(Events& events) : events_(events) {}

  // Control thread only.

  /// `corrector.set`: replaces the matrix. `modes_j`: those that the sensor measures. Errors
  /// (Errc::invalid, fields "shape" and "matrix"): it has not the sensor's modes; wrong number of
  /// bytes; a value is not finite.
  Result<void> set(const CorrectorSet& given, const std::string& bytes, std::vector<int> modes_j);
  void clear();

  /// Report for a sensor that measures `modes_j`. Thread-safe.
  KnownCorrector report(const std::vector<int>& modes_j) const;
  /// Emits an event if the matrix has begun or ceased to fit the sensor's modes. Call it before
  /// each plan becomes active, in the prepare thread.
  void sensor_changed(const std::vector<int>& modes_j);

  // Publish thread only; RT-safe.

  /// The matrix that was set last; null: none.
  const CorrectorMatrix* matrix();
  /// The matrix times the frame's modes. Empty: the frame is not valid, or has other modes. Valid
  /// until the next call.
  std::span<const float> commands(const CorrectorMatrix& matrix, const FrameRecord& record);

 private:
  using Shared = std::shared_ptr<const CorrectorMatrix>;
  void use(Shared matrix);

  Events& events_;
  int sets_ = 0;
  Guarded<Shared> known_;
  LatestValue<Shared> latest_;   ///< the same for the publish thread; the control thread frees it
  std::vector<int> measured_j_;  ///< by the last sensor_changed
  std::vector<float> commands_ = std::vector<float>(std::size_t(limits::kActuators.max));
};

}  // namespace ovws
