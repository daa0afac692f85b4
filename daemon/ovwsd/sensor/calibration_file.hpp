/// Calibrations as files.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// What a file holds of a calibration, and back: the matrix and its standard errors bit for bit;
/// the comparison with the model is not in it. `config`: where the optics and the SLM come from if
/// no registration was in force. Errors (Errc::invalid) say what does not fit together.
nlohmann::json calibration_content(const Calibration& calibration);
Result<Calibration> calibration_from(const nlohmann::json& content, const Config& config);

/// "the calibration of 2026-01-31T12:00:00.000Z"
std::string title_of(const Calibration& calibration);

/// See Kept. `bench` is borrowed.
struct CalibrationKind {
  using Item = Calibration;
  static constexpr const char *kKind = "calibration", *kEvent = "calibration";
  const ReferenceBench* bench;

  std::string title(const Item& calibration) const { return title_of(calibration); }
  /// The same for calibrations of one bench, camera, sensor, tracking, region and registration.
  std::string name(const Item& calibration) const;
  nlohmann::json content(const Item& calibration) const { return calibration_content(calibration); }
  Result<Item> read(const nlohmann::json& content) const {
    return calibration_from(content, bench->config());
  }
  /// Compares it with the model, whatever that says by now.
  std::string obstacle(Item& calibration) const;
  bool needs_other_slm(const Item& calibration) const {
    return bench->has_other_slm_only(*calibration.origin);
  }
  bool fits_slm(const Item& calibration) const {
    return (*calibration.origin)["slm"] == bench->slm();
  }
};
using KeptCalibrations = Kept<CalibrationKind>;

}  // namespace ovws
