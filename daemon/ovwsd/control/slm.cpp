/// lut.*, flatness.*, slm.settle and slm.verify: what the instrument finds out about its own SLM.
#include <array>

#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/procedures/flatness.hpp"
#include "daemon/ovwsd/procedures/lut.hpp"
#include "daemon/ovwsd/procedures/settle.hpp"
#include "proto/tables/job.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json lut_of(const Services& services, const SensorSnapshot& now) {
  LutReport report{now.slm->hologram.lut, services.config.slm.lut, std::nullopt};
  if (const auto& lut = now.slm->lut) {
    report.measured = LutMeasured{lut->t_taken_ns, lut->frames, lut->response,
                                  lut->table,      lut->sha256, lut->origin};
  }
  return to_json(report);
}

void start(Services& services, const char* kind, Procedure procedure, RpcReply reply) {
  services.procedures.start(kind, std::move(procedure),
                            [reply = std::move(reply)](Result<int> job) {
                              if (!job) return reply(failed(job.error()));
                              reply(to_json(JobNumber{*job}));
                            });
}

void run_lut(Services& services, const json& params, RpcReply reply) {
  const auto run = decode<LutRun>(params);
  if (!run) return reply(failed(run.error()));
  start(
      services, "lut.run",
      [&services, run = *run](Bench& bench) -> Result<json> {
        auto lut = measure_lut(bench, services.config.slm.geometry, run);
        if (!lut) return fail(lut.error());
        if (auto used = bench.use_lut(std::move(*lut)); !used) return fail(used.error());
        return lut_of(services, bench.sensor());
      },
      std::move(reply));
}

void get_lut(Services& services, const json& /*params*/, RpcReply reply) {
  reply(lut_of(services, services.instrument.snapshot()));
}

void clear_lut(Services& services, const json& /*params*/, RpcReply reply) {
  services.instrument.clear_lut([&services, reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(failed(cleared.error()));
    reply(lut_of(services, *cleared));
  });
}

json flatness_of(const Services& services, const SensorSnapshot& now) {
  FlatnessReport report{services.config.slm.flatness, std::nullopt};
  if (const auto& f = now.slm->flatness) {
    report.measured =
        FlatnessMeasured{f->t_taken_ns,         f->frames, f->iterations, f->pupil_diameter_px, {},
                         f->residual_rms_waves, f->sha256, f->origin};
    for (std::size_t k = 0; k < f->modes.size(); ++k) {
      report.measured->modes.push_back(
          {f->modes[k].j, f->modes[k].waves, f->standard_error_waves[k]});
    }
  }
  return to_json(report);
}

void run_flatness(Services& services, const json& params, RpcReply reply) {
  const auto asked = decode<FlatnessRun>(params);
  if (!asked) return reply(failed(asked.error()));
  start(
      services, "flatness.run",
      [&services, frames = asked->frames](Bench& bench) -> Result<json> {
        const std::uint64_t epoch = bench.sensor().sensor_epoch;
        auto flatness = measure_flatness(bench, services.config.slm.geometry, frames);
        if (!flatness) return fail(flatness.error());
        if (auto used = bench.use_flatness(epoch, std::move(*flatness)); !used) {
          return fail(used.error());
        }
        return flatness_of(services, bench.sensor());
      },
      std::move(reply));
}

void get_flatness(Services& services, const json& /*params*/, RpcReply reply) {
  reply(flatness_of(services, services.instrument.snapshot()));
}

void clear_flatness(Services& services, const json& /*params*/, RpcReply reply) {
  services.instrument.clear_flatness([&services, reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(failed(cleared.error()));
    reply(flatness_of(services, *cleared));
  });
}

void settle(Services& services, const json& params, RpcReply reply) {
  const auto run = decode<SettleRun>(params);
  if (!run) return reply(failed(run.error()));
  start(
      services, "slm.settle",
      [&services, run = *run](Bench& bench) -> Result<json> {
        const auto time = measure_settle(bench, services.config.slm.geometry, run);
        if (!time) return fail(time.error());
        return to_json(SettleReport{*time, run.repetitions, services.config.slm.settle_ms});
      },
      std::move(reply));
}

void verify(Services& services, const json& /*params*/, RpcReply reply) {
  services.slm.verify([reply](Result<SlmVerdict> seen) {
    if (!seen) return reply(failed(seen.error()));
    reply(to_json(
        VerifyReport{seen->hologram_id, seen->crc32, seen->crc32_shown, seen->differing_pixels}));
  });
}

constexpr std::array<Method, 8> kMethods{{
    {"lut.run", Role::control, Action::start_job, run_lut, decodes<LutRun>},
    {"lut.get", Role::read, Action::read, get_lut},
    {"lut.clear", Role::control, Action::clear_reference, clear_lut},
    {"flatness.run", Role::control, Action::start_job, run_flatness, decodes<FlatnessRun>},
    {"flatness.get", Role::read, Action::read, get_flatness},
    {"flatness.clear", Role::control, Action::clear_reference, clear_flatness},
    {"slm.settle", Role::control, Action::start_job, settle, decodes<SettleRun>},
    {"slm.verify", Role::read, Action::read, verify},
}};

}  // namespace

std::span<const Method> slm_methods() {
  return kMethods;
}

}  // namespace ovws
