/// The document of a recording that describes the templates of the tracker `fit`.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/spots/spot_renderer.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Content of the document: sensor, optics and operating point, which determine the templates.
nlohmann::json point_content(const OperatingPoint& point, const std::vector<int>& modes_j,
                             const SensorSnapshot& sensor, const Roi& roi);

/// Renders the templates of recorded documents again, bit-identical on the same kind of CPU. Keeps
/// the last renderer. Throws exceptions of the JSON library. Used by one thread at a time.
class PointReader {
 public:
  /// Renders the templates for `plan`, whose roi, lit pixels and modes are known, and for its
  /// `calibration` (the document, or null). Errc::invalid, field "path": the document belongs to
  /// other images or modes, or its parts are inconsistent.
  Result<std::shared_ptr<const FrameFit>> read(const nlohmann::json& content,
                                               const MeasurementPlan& plan,
                                               const nlohmann::json& calibration);

 private:
  static Result<std::shared_ptr<const FrameFit>> from_shapes(const nlohmann::json& content,
                                                             const MeasurementPlan& plan,
                                                             const nlohmann::json& calibration);

  std::unique_ptr<SpotRenderer> renderer_;
  std::string renderer_key_;
};

}  // namespace ovws
