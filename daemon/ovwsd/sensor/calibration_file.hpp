/// Calibration files.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// Converts a calibration to the JSON content of its file, and back. The matrix and its standard
/// errors are preserved bit for bit; the comparison with the model is not stored. `config` supplies
/// the SLM's geometry, and the optics if no registration was active. Errors (Errc::invalid) name
/// the inconsistent field.
nlohmann::json calibration_content(const Calibration& calibration);
Result<Calibration> calibration_from(const nlohmann::json& content, const Config& config);

/// Calibrations as a Kind of Kept. `bench` must outlive it.
struct CalibrationKind {
  using Item = Calibration;
  static constexpr const char *kKind = "calibration", *kEvent = kKind, *kTitle = kKind,
                              *kMethod = "calibration.run";
  const ReferenceBench* bench;

  /// Hash of bench, camera, sensor, tracking, region and registration: calibrations that agree in
  /// these share one file.
  std::string name(const Item& calibration) const;
  nlohmann::json content(const Item& calibration) const { return calibration_content(calibration); }
  Result<Item> read(const nlohmann::json& content) const {
    return calibration_from(content, bench->config());
  }
  /// See Kept. Also compares the matrix with the current model, and stores the result.
  std::string obstacle(Item& calibration) const;
};
using KeptCalibrations = Kept<CalibrationKind>;

}  // namespace ovws
