/// Sensor edit: a change of the sensor in progress, which takes effect as a whole or not at all.
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
#include "daemon/ovwsd/sensor/last_renderers.hpp"
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
        optics{config.optics, config.slm.geometry, config.beams},
        hologram(std::move(with_files)),
        origins(config, hologram),
        references(ReferenceKind{&origins}, store, events),
        calibrations(CalibrationKind{&origins}, store, events),
        registrations(RegistrationKind{config.slm.geometry, registration_settings(config)}, store,
                      events),
        luts(LutKind{config}, store, events),
        flatnesses(FlatnessKind{config, flatness_sha256(hologram)}, store, events) {}
  SensorBench(const SensorBench&) = delete;
  SensorBench& operator=(const SensorBench&) = delete;

  const Config config;
  const BenchOptics optics;
  const HologramConfig hologram;  ///< with the configured LUT and flatness
  ReferenceBench origins;
  KeptReferences references;
  KeptCalibrations calibrations;
  KeptRegistration registrations;
  Kept<LutKind> luts;
  Kept<FlatnessKind> flatnesses;
  LastRenderers renderers;                            ///< of prepared lattices
  std::optional<CameraSettings> camera;               ///< last reported settings; none: unknown
  std::uint64_t hologram_id = 0;                      ///< the newest hologram
  std::shared_ptr<const Image<std::uint8_t>> levels;  ///< of that hologram, see hologram_of
};

/// Copies of the sensor's state for a change to modify, and file work to do once the change is
/// active.
struct SensorEdit {
  SensorState state;
  Knowledge knowledge;
  std::optional<SensorShown> before_job;  ///< what to restore when the job that runs ends
  SensorBench& bench;
  bool files_only = false;  ///< state and knowledge are unchanged

  /// Called when the change is active: writes a file and reports the file's checksum. Reports an
  /// empty checksum if writing fails, and the file's checksum if a retry succeeds later.
  std::function<void(std::function<void(const std::string& sha256)>)> keep{};
  /// Called with the checksum that `keep` reports. Sets the item's checksum and nothing else.
  std::function<void(SensorEdit&, const std::string& sha256)> set_checksum{};
  /// Called when the change is active: removes files.
  std::function<void(DaemonStore::Dropped)> drop{};
  /// Called if `drop` cannot remove the files: a change that restores the previous state.
  std::function<Result<void>(SensorEdit&)> undo{};
};

/// A change of the sensor: modifies the edit. If it returns an error, the edit is discarded.
using SensorChange = std::function<Result<void>(SensorEdit&)>;

}  // namespace ovws
