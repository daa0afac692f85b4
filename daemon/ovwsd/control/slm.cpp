/// Methods lut.*, flatness.*, slm.settle and slm.verify: measurements of the SLM itself.
#include <array>

#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/procedures/flatness.hpp"
#include "daemon/ovwsd/procedures/lut.hpp"
#include "daemon/ovwsd/procedures/settle.hpp"

namespace ovws {
namespace {

LutReport lut_of(const Services& services, const SensorSnapshot& now) {
  LutReport report{now.slm->hologram.lut, services.config.slm.lut, std::nullopt};
  if (const auto& lut = now.slm->lut) {
    report.measured = LutMeasured{lut->t_taken_ns, lut->frames, lut->response,
                                  lut->table,      lut->sha256, {lut->origin}};
  }
  return report;
}

void run_lut(Services& services, const LutRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kLutRun.name,
      [&services, run](Bench& bench) -> Result<Json> {
        auto lut = measure_lut(bench, services.config.slm.geometry, run);
        if (!lut) return fail(lut.error());
        if (auto used = bench.use(use_lut(std::move(*lut))); !used) return fail(used.error());
        return to_json(lut_of(services, *bench.sensor()));
      },
      with_job_number(reply));
}

void get_lut(Services& services, Reply<LutReport> reply) {
  reply(lut_of(services, *services.keeper.snapshot()));
}

void clear_lut(Services& services, Reply<LutReport> reply) {
  services.keeper.edit(Hold::unheld(), forget_lut(),
                       [&services, reply](const Result<SensorView>& cleared) {
                         if (!cleared) return reply(cleared.error());
                         reply(lut_of(services, **cleared));
                       });
}

FlatnessReport flatness_of(const Services& services, const SensorSnapshot& now) {
  FlatnessReport report{services.config.slm.flatness, std::nullopt};
  const auto& f = now.slm->flatness;
  if (!f) return report;
  report.measured =
      FlatnessMeasured{f->t_taken_ns,         f->frames, f->iterations, f->pupil_diameter_px, {},
                       f->residual_rms_waves, f->sha256, {f->origin}};
  for (std::size_t k = 0; k < f->modes.size(); ++k) {
    report.measured->modes.push_back(
        {f->modes[k].j, f->modes[k].waves, f->standard_error_waves[k]});
  }
  return report;
}

void run_flatness(Services& services, const FlatnessRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kFlatnessRun.name,
      [&services, run](Bench& bench) -> Result<Json> {
        const std::uint64_t epoch = bench.sensor()->sensor_epoch;
        auto flatness = measure_flatness(bench, services.config.slm.geometry, run.frames);
        if (!flatness) return fail(flatness.error());
        if (auto used = bench.use(use_flatness(epoch, std::move(*flatness))); !used) {
          return fail(used.error());
        }
        return to_json(flatness_of(services, *bench.sensor()));
      },
      with_job_number(reply));
}

void get_flatness(Services& services, Reply<FlatnessReport> reply) {
  reply(flatness_of(services, *services.keeper.snapshot()));
}

void clear_flatness(Services& services, Reply<FlatnessReport> reply) {
  services.keeper.edit(Hold::unheld(), forget_flatness(),
                       [&services, reply](const Result<SensorView>& cleared) {
                         if (!cleared) return reply(cleared.error());
                         reply(flatness_of(services, **cleared));
                       });
}

void settle(Services& services, const SettleRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kSlmSettle.name,
      [&services, run](Bench& bench) -> Result<Json> {
        const auto time = measure_settle(bench, services.config.slm.geometry, run);
        if (!time) return fail(time.error());
        return to_json(SettleReport{*time, run.repetitions, services.config.slm.settle_ms});
      },
      with_job_number(reply));
}

void verify(Services& services, Reply<VerifyReport> reply) {
  services.slm.verify([reply](Result<SlmVerdict> seen) {
    if (!seen) return reply(seen.error());
    reply(VerifyReport{seen->hologram_id, seen->crc32, seen->crc32_shown, seen->differing_pixels});
  });
}

constexpr std::array kRows{
    row<kLutRun, run_lut>(Role::control, Action::start_job),
    row<kLutGet, get_lut>(Role::read, Action::read),
    row<kLutClear, clear_lut>(Role::control, Action::clear_reference),
    row<kFlatnessRun, run_flatness>(Role::control, Action::start_job),
    row<kFlatnessGet, get_flatness>(Role::read, Action::read),
    row<kFlatnessClear, clear_flatness>(Role::control, Action::clear_reference),
    row<kSlmSettle, settle>(Role::control, Action::start_job),
    row<kSlmVerify, verify>(Role::read, Action::read),
};

}  // namespace

std::span<const MethodRow> slm_methods() {
  return kRows;
}

}  // namespace ovws
