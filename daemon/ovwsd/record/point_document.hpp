/// The document of a recording that describes the templates of the tracker `fit`.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/spots/measured_spots.hpp"
#include "core/spots/spot_renderer.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Content of the document: sensor, optics and operating point, which determine the templates.
nlohmann::json point_content(const OperatingPoint& point, const std::vector<int>& modes_j,
                             const SensorSnapshot& sensor, const Roi& roi);

/// Modes from a document. Throws exceptions of the JSON library.
std::vector<Mode> modes_from(const nlohmann::json& all);

/// The document of a calibration in a recording.
struct CalibrationText {
  std::string sha256;  ///< its checksum; empty: there is none
  std::function<nlohmann::json()> read;
};

/// Renders the templates of recorded documents again, bit-identical on the same kind of CPU. Keeps
/// the last renderer and calibration. Throws exceptions of the JSON library, and those of
/// CalibrationText::read. Used by one thread at a time.
class PointReader {
 public:
  /// Renders the templates for `plan`, whose roi, lit pixels and modes are known, and for its
  /// `calibration`, which is read if the templates need it. Errc::invalid, field "path": the
  /// document belongs to other images or modes, or its parts are inconsistent.
  Result<std::shared_ptr<const FrameFit>> read(const nlohmann::json& content,
                                               const MeasurementPlan& plan,
                                               const CalibrationText& calibration);

 private:
  Result<void> use_shapes(const CalibrationText& text, const MeasurementPlan& plan);
  Result<void> use_model(const nlohmann::json& content, const MeasurementPlan& plan);
  Result<void> use_bench(const nlohmann::json& content, const OperatingPoint& point);

  std::unique_ptr<SpotRenderer> renderer_;
  std::string renderer_key_;
  std::string bench_key_;  ///< deviations and correction that the renderer has; empty: unknown
  std::optional<MeasuredShapes> shapes_;
  std::string shapes_sha256_;
};

}  // namespace ovws
