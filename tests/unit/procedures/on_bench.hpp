/// Procedures that tests run on the simulated bench.
#pragma once

#include <vector>

#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "tests/support/simulated_bench.hpp"

namespace ovws::test {

inline Result<nlohmann::json> take_reference_on(SimulatedBench& bench, int frames) {
  return bench.run("reference.take", [frames](Bench& on) {
    return take_reference(on, {frames, false, {}});
  });
}

/// Measures pokes of `modes_j` and uses them.
inline Result<MeasuredCalibration> calibrate_on(SimulatedBench& bench, double amplitude_waves,
                                                const std::vector<int>& modes_j, int frames = 5) {
  MeasuredCalibration found;
  const auto run = bench.run("calibration.run", [&](Bench& on) -> Result<nlohmann::json> {
    const std::uint64_t epoch = on.sensor()->sensor_epoch;
    auto measured = measure_calibration(on, {amplitude_waves, frames, modes_j});
    if (!measured) return fail(measured.error());
    found = *measured;
    if (auto used = on.use(use_calibration(epoch, *measured)); !used) return fail(used.error());
    return nlohmann::json{};
  });
  if (!run) return fail(run.error());
  return found;
}

}  // namespace ovws::test
