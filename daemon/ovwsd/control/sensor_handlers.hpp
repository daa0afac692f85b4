/// Handlers that the methods of the sensor share: report a part of its state, change it, and run a
/// procedure.
#pragma once

#include <utility>

#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// Result type of a method, which `report(services, sensor)` makes.
template <auto report>
using ReportOf = std::invoke_result_t<decltype(report), const Services&, const SensorSnapshot&>;

template <auto report>
void get(Services& services, Reply<ReportOf<report>> reply) {
  reply(report(services, *services.keeper.snapshot()));
}

/// Makes the change, and replies with `report(services, sensor)` of the changed sensor.
template <auto report>
void edit(Services& services, Hold as, SensorChange change, Reply<ReportOf<report>> reply) {
  services.keeper.edit(as, std::move(change),
                       [&services, reply = std::move(reply)](const Result<SensorView>& changed) {
                         if (!changed) return reply(changed.error());
                         reply(report(services, **changed));
                       });
}

template <auto report, auto change>
void clear(Services& services, Reply<ReportOf<report>> reply) {
  edit<report>(services, Hold::unheld(), change(), std::move(reply));
}

/// Starts the job of a method, whose result `measure(services, bench, params)` returns.
template <const auto& method, auto measure>
void run(Services& services, const typename std::remove_cvref_t<decltype(method)>::Params& params,
         Reply<JobNumber> reply) {
  services.procedures.start(
      method.name, [&services, params](Bench& bench) { return measure(services, bench, params); },
      with_job_number(std::move(reply)));
}

/// Activates the measurement of a job. Returns the job's result, which is the report of the sensor.
template <auto report>
Result<Json> use(const Services& services, Bench& bench, SensorChange change) {
  if (auto used = bench.use(std::move(change)); !used) return fail(used.error());
  return to_json(report(services, *bench.sensor()));
}

}  // namespace ovws
