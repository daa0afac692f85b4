/// Bench settings that the results of a gain sweep depend on.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/result.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// Field `bench` of experiment.get: all settings that the sweep itself does not change. `optics`:
/// as configured.
nlohmann::json sweep_bench(const SensorSnapshot& sensor, const CameraSnapshot& camera,
                           nlohmann::json optics);

/// Errc::refused: the message names the settings that have changed. A disconnected camera counts as
/// unchanged.
Result<void> check_same_bench(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace ovws
