/// Context of the sensor: configuration, stored files, latest camera settings and the hologram that
/// is shown.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/calibration_file.hpp"
#include "daemon/ovwsd/sensor/reference_file.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/sensor/registration_file.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"
#include "daemon/ovwsd/slm/slm_kept.hpp"

namespace ovws {

/// Used by the prepare thread only.
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

}  // namespace ovws
