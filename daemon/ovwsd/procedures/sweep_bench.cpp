#include "daemon/ovwsd/procedures/sweep_bench.hpp"

#include <cmath>

#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "proto/tables/origin.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kExposureTolerance = 1e-3;  // relative: a reopened camera may round differently

bool is_same(const std::string& name, const json& before, const json& now) {
  if (name == "camera" && now.is_null()) return true;
  if (name == "exposure_us" && before.is_number() && now.is_number()) {
    const double was_us = before.get<double>();
    return std::abs(now.get<double>() - was_us) <= kExposureTolerance * was_us;
  }
  return before == now;
}

}  // namespace

json sweep_bench(const SensorSnapshot& sensor, const CameraSnapshot& camera, json optics) {
  SweepBench bench;
  bench.program = OVWS_VERSION;
  if (camera.connected) bench.camera = camera_name(camera.info);
  bench.settings = camera.settings;
  bench.sensor.json = to_json(sensor.sensor);
  bench.sensor.json.erase("charge");
  bench.kernel_radius = sensor.tracking.kernel_radius;
  bench.optics.json = std::move(optics);
  bench.slm.json = sensor.slm->identity;
  if (sensor.registration) bench.registration_t_taken_ns = sensor.registration->t_taken_ns;
  bench.correction = sensor.correction;
  return to_json(bench);
}

Result<void> check_same_bench(const json& before, const json& now) {
  std::string changed;
  for (const auto& [name, value] : now.items()) {
    if (is_same(name, before.value(name, json()), value)) continue;
    changed += (changed.empty() ? "" : ", ") + name;
  }
  if (changed.empty()) return {};
  return fail(Errc::refused, "",
              "the bench has changed since the sweep began: " + changed +
                  "; restore it and call again to continue, or call again for a new sweep");
}

}  // namespace ovws
