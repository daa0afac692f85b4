/// reference.* and job.*: what takes time.
#include "proto/tables/reference.hpp"
#include "daemon/ovwsd/control/methods.hpp"
#include "proto/tables/job.hpp"

namespace ovws {
namespace {

KnownReference report_of(const Services& services, const std::optional<Reference>& reference) {
  if (!reference) return {};
  return {ReferenceReport{reference->frames, reference->key.sensor.charge,
                          reference->key.tracking.tracker, reference->t_taken_ns,
                          reference->positions_px, reference->standard_error_px,
                          std::string(reference_source_name(reference->source)), reference->sha256,
                          stale_fields(*reference, services.camera.snapshot().settings),
                          *reference->origin, rms_waves(reference->introduced)}};
}

Instrument::Changed answer(const Services& services, RpcReply reply) {
  return [&services, reply = std::move(reply)](Result<SensorSnapshot> changed) {
    if (!changed) return reply(failed(changed.error()));
    reply(to_json(report_of(services, changed->reference)));
  };
}

void take(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto take = decode<ReferenceTake>(params);
  if (!take) return reply(failed(take.error()));
  services.instrument.take_reference(*take, [reply](Result<int> job) {
    if (!job) return reply(failed(job.error()));
    reply(to_json(JobNumber{*job}));
  });
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(report_of(services, services.instrument.snapshot().reference)));
}

void clear(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.clear_reference(answer(services, std::move(reply)));
}

void set(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.use_model_reference(answer(services, std::move(reply)));
}

void answer_job(const RpcReply& reply, const Result<JobReport>& job) {
  if (!job) return reply(failed(job.error()));
  reply(to_json(*job));
}

void get_job(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto id = decode<JobNumber>(params);
  if (!id) return reply(failed(id.error()));
  answer_job(reply, services.jobs.get(id->job));
}

void cancel_job(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto id = decode<JobNumber>(params);
  if (!id) return reply(failed(id.error()));
  const bool ran = services.jobs.runs(id->job);
  const auto cancelled = services.jobs.cancel(id->job);
  if (!ran) return answer_job(reply, cancelled);
  // Answered when the sensor is free again: the next request may be the next job.
  services.procedures.when_free([&services, reply, cancelled] {
    services.instrument.after_changes([reply, cancelled] { answer_job(reply, cancelled); });
  });
}

constexpr std::array<Method, 6> kMethods{{
    {"reference.take", Role::control, Action::start_job, take, decodes<ReferenceTake>},
    {"reference.get", Role::read, Action::read, get},
    {"reference.set", Role::control, Action::clear_reference, set, decodes<ReferenceSet>},
    {"reference.clear", Role::control, Action::clear_reference, clear},
    {"job.get", Role::read, Action::read, get_job, decodes<JobNumber>},
    {"job.cancel", Role::control, Action::cancel_job, cancel_job, decodes<JobNumber>},
}};

}  // namespace

std::span<const Method> reference_methods() {
  return kMethods;
}

}  // namespace ovws
