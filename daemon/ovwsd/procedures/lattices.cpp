#include <string>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"

namespace ovws {
namespace {

using nlohmann::json;

Result<void> calibrate(Bench& bench) {
  const std::uint64_t epoch = bench.sensor()->sensor_epoch;
  auto measured = measure_calibration(bench, {});
  if (!measured) return fail(measured.error());
  return bench.use(use_calibration(epoch, std::move(*measured)), Bench::Step::early);
}

/// Measures the lattice `name` with the settings `wanted`; adds what was found to `result`.
Result<PreparedLattice> measure_lattice(Bench& bench, const LatticePrepare& asked,
                                        const std::string& name, const SensorSettings& wanted,
                                        json& result) {
  if (auto shown = bench.show(SensorSet::whole(wanted), {}); !shown) return fail(shown.error());
  if (asked.find_exposure) {
    if (auto found = find_exposure(bench, {}); !found) return fail(found.error());
  }
  auto reference = take_reference(
      bench, {.frames = asked.frames, .allow_aberration = false, .beam = {}}, Bench::Step::early);
  if (!reference) return fail(reference.error());
  if (asked.calibrate) {
    if (auto calibrated = calibrate(bench); !calibrated) return fail(calibrated.error());
  }
  const SensorView now = bench.sensor();
  const CameraSettings camera = bench.camera().settings;
  result.push_back({{"name", name},
                    {"subapertures", now->subapertures},
                    {"exposure_us", camera.exposure_us},
                    {"calibrated", now->calibration != nullptr},
                    {"reference", std::move(*reference)}});
  return PreparedLattice{name,
                         {now->sensor, now->tracking},
                         camera.exposure_us,
                         camera.gain_db,
                         camera.gain_raw,
                         now->subapertures,
                         utc_ns()};
}

}  // namespace

Result<json> prepare_lattices(Bench& bench, const LatticePrepare& asked,
                              PreparedLattices& prepared) {
  const SensorView now = bench.sensor();
  const SensorSettings before{now->sensor, now->tracking};  // from which each request counts
  json result = json::array();
  const double share = 1.0 / double(asked.lattices.size());
  for (const LatticeRequest& request : asked.lattices) {
    bench.begin_part(share * double(result.size()), share);
    auto lattice =
        measure_lattice(bench, asked, request.name, request.sensor.applied_to(before), result);
    if (!lattice) {
      Error error = lattice.error();
      error.reason = "lattice " + request.name + ": " + error.reason;
      return fail(std::move(error));
    }
    prepared.keep(lattice->name, *lattice, [end = bench.end()](const Result<std::string>&) {});
  }
  return json{{"lattices", std::move(result)}};
}

}  // namespace ovws
