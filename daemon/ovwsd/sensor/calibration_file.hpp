/// Content of calibration files: measured interaction (poke) matrices as JSON.
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
/// the SLM's geometry, and also the optics if the calibration was measured without a registration.
/// Errors (Errc::invalid) name the inconsistent field.
nlohmann::json calibration_content(const Calibration& calibration);
Result<Calibration> calibration_from(const nlohmann::json& content, const Config& config);

/// Calibrations as the item type of Kept. `bench` must outlive this object.
struct CalibrationKind {
  using Item = Calibration;
  static constexpr const char *kKind = "calibration", *kEvent = kKind, *kTitle = kKind,
                              *kMethod = "calibration.run";
  const ReferenceBench* bench;

  /// File name: hash of bench, camera, sensor, tracking, region and registration. A calibration
  /// with an equal hash overwrites the file.
  std::string name(const Item& calibration) const;
  nlohmann::json content(const Item& calibration) const { return calibration_content(calibration); }
  Result<Item> read(const nlohmann::json& content) const {
    return calibration_from(content, bench->config());
  }
  /// Why the calibration cannot be used on this bench (see Kept); empty: it can. Also compares the
  /// matrix with the current model and sets `calibration.comparison`.
  std::string obstacle(Item& calibration) const;
};
using KeptCalibrations = Kept<CalibrationKind>;

}  // namespace ovws
