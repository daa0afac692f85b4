/// Methods calibration.*: the measured interaction (poke) matrix.
#include <spdlog/fmt/fmt.h>

#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/calibration.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/calibration.hpp"

namespace ovws {
namespace {

KnownCalibration report_of(const SensorSnapshot& sensor) {
  if (!sensor.calibration) return {};
  const Calibration& c = *sensor.calibration;
  return {sensor.mode_operator.in_force == OperatorKind::measured,
          CalibrationReport{c.amplitude_waves,
                            c.frames,
                            c.t_taken_ns,
                            c.matrix,
                            c.comparison,
                            c.shapes ? c.shapes->modes_j : std::vector<int>{},
                            c.sha256,
                            {*c.origin}}};
}

/// Warns of a calibration without some spots or modes: it is usable, but a person must know.
void warn_of_dropped(Bench& bench, const InteractionMatrix& matrix) {
  std::vector<int> dropped_j;
  for (const DroppedMode& mode : matrix.dropped) dropped_j.push_back(mode.j);
  if (dropped_j.empty() && matrix.lost_spots.empty()) return;
  std::string text = "the calibration";
  if (!matrix.lost_spots.empty()) {
    text += fmt::format(" lacks spots {}", listed_spots(matrix.lost_spots));
  }
  if (!dropped_j.empty()) {
    text += fmt::format(
        "{} does not measure modes j = {} ({}): their aberration appears as other modes",
        matrix.lost_spots.empty() ? "" : " and", listed_spots(dropped_j), matrix.dropped[0].reason);
  }
  bench.warn("calibration", text,
             {{"lost_spots", matrix.lost_spots}, {"dropped_modes", dropped_j}});
}

void run(Services& services, const CalibrationRun& run, Reply<JobNumber> reply) {
  if (services.keeper.snapshot()->pattern != HologramKind::sensor) {
    return reply(Error{Errc::refused, "",
                       "the SLM does not show the sensor: call slm.show with \"sensor\" first"});
  }
  services.procedures.start(
      kCalibrationRun.name,
      [slm = services.config.slm.geometry, run](Bench& bench) -> Result<Json> {
        const std::uint64_t epoch = bench.sensor()->sensor_epoch;
        const auto measured = measure_calibration(bench, slm, run);
        if (!measured) return fail(measured.error());
        if (auto used = bench.use(use_calibration(epoch, *measured)); !used) {
          return fail(used.error());
        }
        warn_of_dropped(bench, measured->matrix);
        return to_json(report_of(*bench.sensor()));
      },
      with_job_number(reply));
}

void get(Services& services, Reply<KnownCalibration> reply) {
  reply(report_of(*services.keeper.snapshot()));
}

void clear(Services& services, Reply<KnownCalibration> reply) {
  services.keeper.edit(Hold::unheld(), forget_calibration(), with_report(reply, report_of));
}

constexpr std::array kRows{
    row<kCalibrationRun, run>(Role::control, Action::start_job),
    row<kCalibrationGet, get>(Role::read, Action::read),
    row<kCalibrationClear, clear>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> calibration_methods() {
  return kRows;
}

}  // namespace ovws
