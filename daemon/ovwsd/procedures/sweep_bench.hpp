/// What the numbers of a gain sweep are of.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/result.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// `bench` of experiment.get: all that a sweep does not change itself. `optics` as in the
/// configuration.
nlohmann::json sweep_bench(const SensorSnapshot& sensor, const CameraSnapshot& camera,
                           nlohmann::json optics);

/// Errc::refused, naming what is not as it was. A camera that is away just now has not changed.
Result<void> check_same_bench(const nlohmann::json& before, const nlohmann::json& now);

}  // namespace ovws
