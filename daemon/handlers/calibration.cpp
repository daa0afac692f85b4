/// registration.*: what the bench measures of itself.
#include "daemon/handlers/methods.hpp"
#include "daemon/procedures/registration.hpp"
#include "proto/results.hpp"

namespace ovws {
namespace {

void start(Services& services, const char* kind, Procedure procedure, const RpcReply& reply) {
  services.procedures.start(kind, std::move(procedure), [reply](Result<int> job) {
    if (!job) return reply(failed(job.error()));
    reply(job_started_result(*job));
  });
}

void run_registration(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto frames = decode_registration_run(params);
  if (!frames) return reply(failed(frames.error()));
  const SlmGeometry slm = services.config.slm.geometry;
  start(
      services, "registration.run",
      [slm, frames = *frames](Bench& bench) -> Result<nlohmann::json> {
        const auto found = measure_registration(bench, slm, frames);
        if (!found) return fail(found.error());
        if (auto used = bench.use_registration(*found); !used) return fail(used.error());
        return registration_result(*found);
      },
      reply);
}

void get_registration(Services& services, const nlohmann::json& params, RpcReply reply) {
  if (const auto nothing = decode_nothing(params); !nothing) return reply(failed(nothing.error()));
  reply(registration_result(services.instrument.snapshot().registration));
}

void clear_registration(Services& services, const nlohmann::json& params, RpcReply reply) {
  if (const auto nothing = decode_nothing(params); !nothing) return reply(failed(nothing.error()));
  services.instrument.clear_registration([reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(failed(cleared.error()));
    reply(registration_result(cleared->registration));
  });
}

constexpr std::array<Method, 3> kMethods{{
    {"registration.run", Action::start_job, run_registration},
    {"registration.get", Action::read, get_registration},
    {"registration.clear", Action::clear_reference, clear_registration},
}};

}  // namespace

std::span<const Method> calibration_methods() {
  return kMethods;
}

}  // namespace ovws
