/// A change of the sensor in progress. It takes effect as a whole, or not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/calibration_file.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/reference_file.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/sensor/registration_file.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"

namespace ovws {

/// Context of the sensor: configuration, stored files, latest camera settings and the hologram that
/// is shown. Used by the prepare thread only.
struct SensorBench {
  SensorBench(const Config& as_configured, HologramConfig with_files, DaemonStore& store,
              Events& events)
      : config(as_configured),
        optics{config.optics, config.slm.geometry},
        hologram(std::move(with_files)),
        origins(config, hologram),
        references(ReferenceKind{&origins}, store, events),
        calibrations(CalibrationKind{&origins}, store, events),
        registrations(RegistrationKind{config.slm.geometry}, store, events),
        luts(LutKind{config}, store, events),
        flatnesses(FlatnessKind{config, flatness_sha256(hologram)}, store, events) {}
  SensorBench(const SensorBench&) = delete;
  SensorBench& operator=(const SensorBench&) = delete;

  const Config config;
  const BenchOptics optics;
  const HologramConfig hologram;  ///< with LUT and flatness as configured
  ReferenceBench origins;
  KeptReferences references;
  KeptCalibrations calibrations;
  KeptRegistration registrations;
  Kept<LutKind> luts;
  Kept<FlatnessKind> flatnesses;
  std::optional<CameraSettings> camera;             ///< as last reported; none: unknown
  std::uint64_t hologram_id = 0;                    ///< the hologram shown last
  std::shared_ptr<const Image<std::uint8_t>> grey;  ///< its grey levels
};

/// Copies of the sensor's state that a change modifies, and what to do once it is active.
struct SensorEdit {
  SensorState state;
  Knowledge knowledge;
  std::optional<SensorShown> lease;  ///< what to restore when the job that holds the sensor ends
  SensorBench& bench;
  bool files_only = false;  ///< state and knowledge are unchanged

  /// Called when the change is active: writes a file and reports its checksum. Reports an empty
  /// checksum if writing fails, and the real one if a retry succeeds later.
  std::function<void(std::function<void(const std::string& sha256)>)> keep{};
  /// Called with that checksum. Changes nothing but the checksum of the item.
  std::function<void(SensorEdit&, const std::string& sha256)> set_checksum{};
  /// Called when the change is active: removes files.
  std::function<void(DaemonStore::Dropped)> drop{};
  /// Called if they cannot be removed: a change that restores the previous state.
  std::function<Result<void>(SensorEdit&)> undo{};
};

/// Modifies the edit. On an error nothing changes.
using SensorChange = std::function<Result<void>(SensorEdit&)>;

}  // namespace ovws
