/// Handlers that the methods of the sensor share: report a part of its state, change it, and run a
/// procedure.
#pragma once

#include <functional>
#include <type_traits>
#include <utility>

#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// Result type of a method, which `report(services, sensor)` makes.
template <auto report>
using ReportOf = std::invoke_result_t<decltype(report), const Services&, const SensorSnapshot&>;

template <auto report>
void get(Services& services, const Reply<ReportOf<report>>& reply) {
  reply(report(services, *services.keeper.snapshot()));
}

/// Makes the change, and replies with `report(services, sensor)` of the changed sensor.
template <auto report>
void edit(Services& services, SensorChange change, const Reply<ReportOf<report>>& reply) {
  services.keeper.edit(
      std::move(change),
      [&services, reply](const Result<SensorView>& changed) {
        if (!changed) return reply(changed.error());
        reply(report(services, **changed));
      },
      [reply] { reply.end_lease(); });  // its files may take minutes
}

template <auto report, auto change>
void clear(Services& services, const Reply<ReportOf<report>>& reply) {
  edit<report>(services, change(), reply);
}

inline Result<Json> json_result(Result<Json> result) {
  return result;
}
template <class T>
Result<Json> json_result(const Result<T>& result) {
  if (!result) return fail(result.error());
  return to_json(*result);
}

/// Starts the job of a method with the lease of the call, and replies with its number. Its result
/// is that of `measure(services, bench, params)`, or of `measure(bench, params)`. `can`: see
/// Procedures::Start.
template <const auto& method, auto measure>
void run_if(Services& services,
            const typename std::remove_cvref_t<decltype(method)>::Params& params,
            const Reply<JobNumber>& reply, std::function<Result<void>(const SensorSnapshot&)> can) {
  const auto procedure = [&services, params](Bench& bench) {
    (void)services;  // a measurement of the bench alone takes none
    if constexpr (std::is_invocable_v<decltype(measure), Bench&, decltype(params)>) {
      return json_result(measure(bench, params));
    } else {
      return json_result(measure(services, bench, params));
    }
  };
  services.procedures.start(reply.take_lease(), {method.name, procedure, std::move(can)},
                            [reply](const Result<int>& job) {
                              if (!job) return reply(job.error());
                              reply(JobNumber{*job});
                            });
}
template <const auto& method, auto measure, auto can = nullptr>
void run(Services& services, const typename std::remove_cvref_t<decltype(method)>::Params& params,
         const Reply<JobNumber>& reply) {
  run_if<method, measure>(services, params, reply, can);
}

/// Activates the measurement of a job. Returns the job's result, which is the report of the sensor.
template <auto report>
Result<Json> use(const Services& services, Bench& bench, SensorChange change) {
  if (auto used = bench.use(std::move(change)); !used) return fail(used.error());
  return to_json(report(services, *bench.sensor()));
}

}  // namespace ovws
