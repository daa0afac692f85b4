/// Methods reference.*: the reference positions, from which displacements are measured.
#include "daemon/ovwsd/procedures/reference.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {
namespace {

KnownReference report_of(const Services& services, const Reference* reference) {
  if (reference == nullptr) return {};
  return {ReferenceReport{reference->frames,
                          reference->key.sensor.charge,
                          reference->key.tracking.tracker,
                          reference->t_taken_ns,
                          reference->positions_px,
                          reference->standard_error_px,
                          std::string(reference_source_name(reference->source)),
                          reference->sha256,
                          stale_fields(*reference, services.camera.snapshot().settings),
                          {*reference->origin},
                          rms_waves(reference->introduced)}};
}

auto with_reference(const Services& services, Reply<KnownReference> reply) {
  return with_report(reply, [&services](const SensorSnapshot& now) {
    return report_of(services, now.reference.get());
  });
}

void take(Services& services, const ReferenceTake& take, Reply<JobNumber> reply) {
  if (auto can = can_take_reference(*services.keeper.snapshot(), take); !can) {
    return reply(can.error());
  }
  services.procedures.start(
      kReferenceTake.name, [take](Bench& bench) { return take_reference(bench, take); },
      with_job_number(reply));
}

void get(Services& services, Reply<KnownReference> reply) {
  reply(report_of(services, services.keeper.snapshot()->reference.get()));
}

void clear(Services& services, Reply<KnownReference> reply) {
  services.keeper.edit(Hold::unheld(), forget_reference(), with_reference(services, reply));
}

void set(Services& services, const ReferenceSet& /*to*/, Reply<KnownReference> reply) {
  services.keeper.edit(Hold::unheld(), use_model_reference(), with_reference(services, reply));
}

constexpr std::array kRows{
    row<kReferenceTake, take>(Role::control, Action::start_job),
    row<kReferenceGet, get>(Role::read, Action::read),
    row<kReferenceSet, set>(Role::control, Action::clear_reference),
    row<kReferenceClear, clear>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> reference_methods() {
  return kRows;
}

}  // namespace ovws
