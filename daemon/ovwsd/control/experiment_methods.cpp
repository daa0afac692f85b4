/// Methods experiment.*: the paper's gain sweep, which compares sensors at several camera gains.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_limits.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/gain_sweep.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "proto/tables/experiment.hpp"

namespace ovws {
namespace {

/// Checks the gains against the camera's range. With `clamp`, removes entries of gains_db outside
/// the range. Errc::invalid: the reference gain is outside the range; without `clamp`, an entry of
/// gains_db is outside; no gain remains; or the camera has no gain in dB.
Result<GainSweepRun> within(GainSweepRun run, const CameraLimits& limits) {
  GainSweep& sweep = run.sweep;
  if (limits.gain_raw) return fail(no_gain_in_db("gains_db", limits));
  const Range<double>& range = limits.gain_db;
  const auto check = [&range](const char* field, double gain_db,
                              const char* advice = "") -> Result<void> {
    if (gain_db >= range.min && gain_db <= range.max) return {};
    return fail(Error{
        Errc::invalid, field,
        fmt::format("{} dB is outside the camera's range of {} to {} dB: choose another gain{}",
                    gain_db, range.min, range.max, advice),
        range.min, range.max});
  };
  if (auto has = check("reference_gain_db", sweep.reference_gain_db); !has)
    return fail(has.error());
  if (run.clamp) {
    std::erase_if(sweep.gains_db, [&](double gain_db) { return !check("", gain_db); });
    if (!sweep.gains_db.empty()) return run;
    return fail(
        Errc::invalid, "gains_db",
        fmt::format("all of these gains are outside the camera's range of {} to {} dB: give "
                    "one within it",
                    range.min, range.max));
  }
  for (const double gain_db : sweep.gains_db) {
    auto has = check("gains_db", gain_db, ", or leave out such gains with \"clamp\"");
    if (!has) return fail(has.error());
  }
  return run;
}

ExperimentRun asked_now(const Services& services, const GainSweepRun& asked) {
  return experiment_run(asked, sweep_bench(*services.keeper.snapshot(), services.camera.snapshot(),
                                           to_json(services.config.optics)));
}

void start(Services& services, LeasePtr lease, const ExperimentRun& run,
           const Reply<JobNumber>& reply) {
  const SlmGeometry slm = services.config.slm.geometry;
  ExperimentArchive& archive = services.experiments;
  const auto measure = [slm, run, &archive](Bench& bench) -> Result<Json> {
    const std::shared_ptr<void> ended(nullptr, [&archive](void*) { archive.end_job(); });
    const auto measured = measure_gain_sweep(bench, slm, run, archive);
    if (!measured) return fail(measured.error());
    return Json{{"run", run.name}};
  };
  services.procedures.start(std::move(lease), kExperimentGainSweep.name, measure,
                            [reply, &archive, run](Result<int> job) {
                              if (job) archive.begin_job(run, *job);
                              if (!job) return reply(job.error());
                              reply(JobNumber{*job});
                            });
}

/// Starts a gain sweep. Replies with the job's number if a job already measures the run.
void gain_sweep(Services& services, GainSweepRun asked, const Reply<JobNumber>& reply) {
  if (const auto limits = services.camera.snapshot().limits) {
    auto possible = within(std::move(asked), *limits);
    if (!possible) return reply(possible.error());
    asked = std::move(*possible);
  }
  const ExperimentRun run = asked_now(services, asked);
  const auto job = services.experiments.job_of(run.name);
  if (job && services.jobs.runs(*job) && !asked.anew) return reply(JobNumber{*job});
  auto lease = services.leases.take(Request::run_hologram_job);
  if (!lease) return reply(lease.error());
  start(services, std::move(*lease), run, reply);
}

void get_experiment(Services& services, const Reply<KnownExperiment>& reply) {
  reply(JsonOf<KnownExperiment>{services.experiments.result()});
}

void get_cell(Services& services, const ExperimentCell& which, const Reply<CellReport>& reply) {
  services.experiments.cell(which.cell, [reply](Result<Json> cell) {
    if (!cell) return reply(cell.error());
    reply(JsonOf<CellReport>{std::move(*cell)});
  });
}

constexpr std::array kExperimentRows{
    row<kExperimentGainSweep, gain_sweep>(Role::control, Request::read),
    row<kExperimentGet, get_experiment>(Role::read, Request::read),
    row<kExperimentCell, get_cell>(Role::read, Request::read),
};

}  // namespace

std::span<const MethodRow> experiment_methods() {
  return kExperimentRows;
}

}  // namespace ovws
