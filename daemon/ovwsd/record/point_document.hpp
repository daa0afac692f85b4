/// The document of a recording that describes the templates of the tracker `fit`.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "core/base/result.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/spots/spot_renderer.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Sensor, optics and operating point: all that determines the templates.
nlohmann::json point_content(const OperatingPoint& point, const std::vector<int>& modes_j,
                             const SensorSnapshot& sensor, const Roi& roi);

/// Renders the templates of such a document again: the same, bit for bit, on the same kind of CPU.
/// Keeps the last renderer. Throws exceptions of the JSON library. One thread at a time.
class PointReader {
 public:
  /// `roi`, `modes_j` (valid ones) and `calibration` (its document, or null): of the plan.
  /// Errc::invalid, field "path": the document has others, or parts that do not fit.
  Result<std::shared_ptr<const FrameFit>> read(const nlohmann::json& content, const Roi& roi,
                                               const std::vector<int>& modes_j,
                                               const nlohmann::json& calibration);

 private:
  static Result<std::shared_ptr<const FrameFit>> from_shapes(const nlohmann::json& content,
                                                             const Roi& roi,
                                                             const std::vector<int>& modes_j,
                                                             const nlohmann::json& calibration);

  std::unique_ptr<SpotRenderer> renderer_;
  std::string renderer_key_;
};

}  // namespace ovws
