/// Methods job.*: the progress and the end of long commands.
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {
namespace {

void get(Services& services, const JobNumber& which, Reply<JobReport> reply) {
  reply(services.jobs.get(which.job));
}

void cancel(Services& services, const JobNumber& which, Reply<JobReport> reply) {
  const bool ran = services.jobs.runs(which.job);
  const auto cancelled = services.jobs.cancel(which.job);
  if (!ran || services.jobs.runs(which.job)) return reply(cancelled);
  // Replies when the sensor is free again, so that the client can start the next job at once.
  services.procedures.when_free([&services, reply, cancelled] {
    services.keeper.after_changes([reply, cancelled] { reply(cancelled); });
  });
}

constexpr std::array kRows{
    row<kJobGet, get>(Role::read, Action::read),
    row<kJobCancel, cancel>(Role::control, Action::cancel_job),
};

}  // namespace

std::span<const MethodRow> job_methods() {
  return kRows;
}

}  // namespace ovws
