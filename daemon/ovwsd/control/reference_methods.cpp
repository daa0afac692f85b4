/// Methods of references: the active one, and those saved by name.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "daemon/ovwsd/library/named_items.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {
namespace {

KnownReference reference_of(const Services& services, const SensorSnapshot& now) {
  if (!now.reference) return {};
  const Reference& r = *now.reference;
  return {ReferenceReport{r.frames,
                          r.key.sensor.charge,
                          r.key.tracking.tracker,
                          r.t_taken_ns,
                          r.positions_px,
                          r.standard_error_px,
                          std::string(wire_name(r.source)),
                          sha256_of(services.library, r),
                          stale_fields(r, services.camera.snapshot().settings),
                          {*r.origin},
                          rms_waves(r.introduced)}};
}

Result<Json> refer(Bench& bench, const ReferenceTake& take) {
  return take_reference(bench, take);
}

void run_reference(Services& services, const ReferenceTake& params, const Reply<JobNumber>& reply) {
  run_if<kReferenceTake, refer>(services, params, reply, [params](const SensorSnapshot& now) {
    return can_take_reference(now, params);
  });
}

/// Positions and standard errors of a request's binary frame, see kReferenceGive.
Result<SpotAverage> positions_from(const ReferenceGive& given, const std::string& bytes) {
  constexpr std::size_t kSpotBytes = 4 * sizeof(float);
  constexpr double kMaxErrorPx = 100.0;
  if (bytes.empty() || bytes.size() % kSpotBytes != 0) {
    return fail(Errc::invalid, "positions",
                "must be a binary frame of 2 x N x 2 float32 after the JSON");
  }
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  const std::size_t spots = bytes.size() / kSpotBytes;
  SpotAverage average;
  average.frames = given.frames;
  for (std::size_t i = 0; i < spots; ++i) {
    const Vec2 at{values[2 * i], values[2 * i + 1]};
    const Vec2 error{values[2 * (spots + i)], values[2 * (spots + i) + 1]};
    const bool found = std::isfinite(at.x) && std::isfinite(at.y);
    if (found && !(error.x >= 0.0 && error.y >= 0.0 && std::max(error.x, error.y) <= kMaxErrorPx)) {
      return fail(Errc::invalid, "positions",
                  fmt::format("the standard errors of spot {} must be numbers from 0 to {} px", i,
                              kMaxErrorPx));
    }
    average.mean_px.push_back(at);
    average.standard_error_px.push_back(error);
    average.found.push_back(found ? given.frames : 0);
  }
  return average;
}

void give_reference(Services& services, const ReferenceGive& params, const std::string& positions,
                    const Reply<KnownReference>& reply) {
  auto given = positions_from(params, positions);
  if (!given) return reply(given.error());
  edit<reference_of>(services, use_given_reference(std::move(*given)), reply);
}

void use_model(Services& services, const ReferenceSet& /*to*/, const Reply<KnownReference>& reply) {
  edit<reference_of>(services, use_model_reference(), reply);
}

/// Makes a question to the sensor that replies with the list.
auto listing(const Services& services, const Reply<ReferenceList>& reply) {
  return [all = services.named.all(), reply](const SensorEdit& now) {
    ReferenceList list;
    for (const auto& [name, reference] : all) {
      list.references.push_back(
          {name, reference->t_taken_ns,
           unused_reason(*reference, now.state, now.knowledge, now.bench.optics, true)});
    }
    reply(list);
  };
}

void list_references(Services& services, const Reply<ReferenceList>& reply) {
  services.keeper.ask_in_spare_time(listing(services, reply));
}

/// Makes a callback that replies with the list, or with the error.
NamedReferences::Done then_list(Services& services, const Reply<ReferenceList>& reply) {
  return [&services, reply](const Result<void>& done) {
    if (!done) return reply(done.error());
    services.keeper.ask(listing(services, reply));
  };
}

void save_reference(Services& services, const ReferenceName& params,
                    const Reply<ReferenceList>& reply) {
  const auto active = services.keeper.snapshot()->reference;
  if (!active) {
    return reply(Error{Errc::refused, "", "there is no reference: take one with reference.take"});
  }
  services.named.add(params.name, active, then_list(services, reply));
}

void load_reference(Services& services, const ReferenceName& params,
                    const Reply<KnownReference>& reply) {
  reply.end_lease();  // the disk may not answer for minutes
  services.named.read(params.name, [&services, reply](Result<Reference> found) {
    if (!found) return reply(found.error());
    auto lease = services.leases.take(Request::set_measured);
    if (!lease) return reply(lease.error());
    edit<reference_of>(services, use_saved_reference(std::move(*found)), reply.with(*lease));
  });
}

void delete_reference(Services& services, const ReferenceName& params,
                      const Reply<ReferenceList>& reply) {
  services.named.remove(params.name, then_list(services, reply));
}

// Saving and deleting change files only, whatever the bench is doing.
constexpr Request kFilesOnly = Request::act;

constexpr std::array kReferenceRows{
    row<kReferenceTake, run_reference>(Role::control, Request::run_job),
    row<kReferenceGet, get<reference_of>>(Role::read, Request::read),
    row<kReferenceSet, use_model>(Role::control, Request::set_measured),
    row<kReferenceGive, give_reference>(Role::control, Request::set_measured),
    row<kReferenceClear, clear<reference_of, forget_reference>>(Role::control,
                                                                Request::set_measured),
    row<kReferenceDelete, delete_reference>(Role::control, kFilesOnly),
    row<kReferenceList, list_references>(Role::read, Request::read),
    row<kReferenceLoad, load_reference>(Role::control, Request::set_measured),
    row<kReferenceSave, save_reference>(Role::control, kFilesOnly),
};

}  // namespace

std::span<const MethodRow> reference_methods() {
  return kReferenceRows;
}

}  // namespace ovws
