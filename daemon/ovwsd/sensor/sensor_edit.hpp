/// Sensor edit: a change of the sensor in progress, which takes effect as a whole or not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/library/items.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/last_renderers.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// Context of the sensor: configuration, stored items, latest camera settings and the hologram that
/// is shown. Used by the prepare thread only.
struct SensorBench {
  SensorBench(const Config& as_configured, HologramConfig with_files, Library& items)
      : config(as_configured),
        optics{config.optics, config.slm.geometry, config.beams, flatness_sha256(with_files),
               array_json(config)},
        hologram(std::move(with_files)),
        library(items) {}
  SensorBench(const SensorBench&) = delete;
  SensorBench& operator=(const SensorBench&) = delete;

  const Config config;
  const BenchOptics optics;
  const HologramConfig hologram;  ///< with the configured LUT and flatness
  Library& library;
  LastRenderers renderers;                            ///< of prepared lattices
  std::optional<CameraSettings> camera;               ///< last reported settings; none: unknown
  std::uint64_t hologram_id = 0;                      ///< the newest hologram
  std::shared_ptr<const Image<std::uint8_t>> levels;  ///< of that hologram, see hologram_of
};

struct SensorEdit;
/// Items that a change has removed, of one kind. They are put back if their files cannot be
/// removed.
struct RemovedItems {
  const ItemKind* kind = nullptr;  ///< null: none were removed
  std::vector<std::string> names;  ///< of the files
  /// Undoes the deletion, except of what has been measured again since.
  std::function<void(SensorEdit&)> put_back{};
};

/// Copies of the sensor's state for a change to modify, and file work to do once the change is
/// active.
struct SensorEdit {
  SensorState state;
  Knowledge knowledge;
  std::optional<SensorShown> before_job;  ///< what to restore when the job that runs ends
  SensorBench& bench;
  bool files_only = false;  ///< state and knowledge are unchanged

  std::function<Library::Item()> stored{};  ///< makes the item to write; empty: none
  RemovedItems removed{};
};

/// A change of the sensor: modifies the edit. If it returns an error, the edit is discarded.
using SensorChange = std::function<Result<void>(SensorEdit&)>;

}  // namespace ovws
