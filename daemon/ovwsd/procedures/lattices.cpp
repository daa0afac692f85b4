#include <string>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"

namespace ovws {
namespace {

using nlohmann::json;

/// Measures one lattice after another. The keys of each request count from the sensor in use.
class Preparation {
 public:
  Preparation(Bench& bench, const LatticePrepare& asked) : bench_(bench), asked_(asked) {
    const SensorView now = bench.sensor();
    before_ = {now->sensor, now->tracking};
  }

  /// Measures the lattice; adds what was found to `result`.
  Result<PreparedLattice> measure(const LatticeRequest& request, json& result) {
    const SensorSettings wanted = request.sensor.applied_to(before_);
    if (auto shown = bench_.show(SensorSet::whole(wanted), {}); !shown) return fail(shown.error());
    if (asked_.find_exposure) {
      if (auto found = find_exposure(bench_, {}); !found) return fail(found.error());
    }
    auto reference =
        take_reference(bench_, {.frames = asked_.frames, .allow_aberration = false, .beam = {}},
                       Bench::Step::early);
    if (!reference) return fail(reference.error());
    if (asked_.calibrate) {
      if (auto calibrated = calibrate(); !calibrated) return fail(calibrated.error());
    }
    const SensorView now = bench_.sensor();
    const CameraSettings camera = bench_.camera().settings;
    result.push_back({{"name", request.name},
                      {"subapertures", now->subapertures},
                      {"exposure_us", camera.exposure_us},
                      {"calibrated", now->calibration != nullptr},
                      {"reference", std::move(*reference)}});
    return PreparedLattice{request.name,
                           {now->sensor, now->tracking},
                           camera.exposure_us,
                           camera.gain_db,
                           camera.gain_raw,
                           now->subapertures,
                           utc_ns()};
  }

 private:
  Result<void> calibrate() {
    const std::uint64_t epoch = bench_.sensor()->sensor_epoch;
    auto measured = measure_calibration(bench_, {});
    if (!measured) return fail(measured.error());
    return bench_.use(use_calibration(epoch, std::move(*measured)), Bench::Step::early);
  }

  Bench& bench_;
  const LatticePrepare& asked_;
  SensorSettings before_;
};

}  // namespace

Result<json> prepare_lattices(Bench& bench, const LatticePrepare& asked,
                              PreparedLattices& prepared) {
  Preparation preparation(bench, asked);
  json result = json::array();
  const double share = 1.0 / double(asked.lattices.size());
  for (const LatticeRequest& request : asked.lattices) {
    bench.begin_part(share * double(result.size()), share);
    auto lattice = preparation.measure(request, result);
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
