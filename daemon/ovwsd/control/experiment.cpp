/// experiment.*: the paper's comparison of sensors against the camera's gain.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>

#include "daemon/ovwsd/camera/camera_limits.hpp"
#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/procedures/gain_sweep.hpp"
#include "daemon/ovwsd/procedures/sweep_bench.hpp"
#include "proto/tables/job.hpp"

namespace ovws {
namespace {

using nlohmann::json;

/// Gains that the camera has not are an error, or left out.
Result<GainSweepRun> within(GainSweepRun run, const CameraLimits& limits) {
  GainSweep& sweep = run.sweep;
  if (limits.gain_raw) return fail(no_gain_in_db("gains_db", limits));
  const Range<double>& range = limits.gain_db;
  const auto check = [&range](const char* field, double gain_db) -> Result<void> {
    if (gain_db >= range.min && gain_db <= range.max) return {};
    return fail(
        Error{Errc::invalid, field,
              fmt::format("the camera's gain is from {} to {} dB, {} is not: choose others, "
                          "or leave out with \"clamp\" those that it has not",
                          range.min, range.max, gain_db),
              range.min, range.max});
  };
  if (auto has = check("reference_gain_db", sweep.reference_gain_db); !has)
    return fail(has.error());
  if (run.clamp) {
    std::erase_if(sweep.gains_db, [&](double gain_db) { return !check("", gain_db); });
    if (!sweep.gains_db.empty()) return run;
    return fail(Errc::invalid, "gains_db", "the camera has none of these gains");
  }
  for (const double gain_db : sweep.gains_db) {
    if (auto has = check("gains_db", gain_db); !has) return fail(has.error());
  }
  return run;
}

ExperimentRun asked_now(const Services& services, const GainSweepRun& asked) {
  const json config = json::parse(dump_config(services.config));
  return experiment_run(asked, sweep_bench(services.instrument.snapshot(),
                                           services.camera.snapshot(), config["optics"]));
}

void start(Services& services, const ExperimentRun& run, const RpcReply& reply) {
  const SlmGeometry slm = services.config.slm.geometry;
  ExperimentArchive& archive = services.experiments;
  const auto measure = [slm, run, &archive](Bench& bench) -> Result<json> {
    const std::shared_ptr<void> ended(nullptr, [&archive](void*) { archive.end_job(); });
    const auto measured = measure_gain_sweep(bench, slm, run, archive);
    if (!measured) return fail(measured.error());
    return json{{"run", run.name}};
  };
  services.procedures.start("experiment.gain_sweep", measure,
                            [reply, &archive, run](Result<int> job) {
                              if (!job) return reply(failed(job.error()));
                              archive.begin_job(run, *job);
                              reply(to_json(JobNumber{*job}));
                            });
}

/// Who asks for the run that is being measured is given its job.
void gain_sweep(Services& services, const json& params, RpcReply reply) {
  auto asked = decode<GainSweepRun>(params);
  if (!asked) return reply(failed(asked.error()));
  const CameraSnapshot camera = services.camera.snapshot();
  if (camera.limits) asked = within(std::move(*asked), *camera.limits);
  if (!asked) return reply(failed(asked.error()));
  const ExperimentRun run = asked_now(services, *asked);
  const auto job = services.experiments.job_of(run.name);
  if (job && services.jobs.runs(*job) && !asked->anew) return reply(to_json(JobNumber{*job}));
  if (auto allowed = services.state.check(Action::start_job); !allowed) {
    return reply(failed(allowed.error()));
  }
  start(services, run, reply);
}

void get(Services& services, const json& /*params*/, RpcReply reply) {
  reply(services.experiments.result());
}

void get_cell(Services& services, const json& params, RpcReply reply) {
  const auto number = decode<ExperimentCell>(params);
  if (!number) return reply(failed(number.error()));
  services.experiments.cell(number->cell, [reply = std::move(reply)](Result<json> cell) {
    if (!cell) return reply(failed(cell.error()));
    reply(std::move(*cell));
  });
}

constexpr std::array<Method, 3> kMethods{{
    {"experiment.gain_sweep", Role::control, Action::read, gain_sweep, decodes<GainSweepRun>},
    {"experiment.get", Role::read, Action::read, get},
    {"experiment.cell", Role::read, Action::read, get_cell, decodes<ExperimentCell>},
}};

}  // namespace

std::span<const Method> experiment_methods() {
  return kMethods;
}

}  // namespace ovws
