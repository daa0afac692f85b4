/// Methods lattice.*: prepared lattices, and switching between them.
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <set>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/prepared_lattices.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {
namespace {

/// Makes a question to the sensor that replies with the list.
auto listing(const Services& services, const Reply<LatticeList>& reply) {
  return [all = services.lattices.all(), reply](const SensorEdit& now) {
    LatticeList list;
    for (const auto& [name, lattice] : all) list.lattices.push_back(report_of(*lattice, now));
    reply(list);
  };
}

void list(Services& services, const Reply<LatticeList>& reply) {
  services.keeper.ask_in_spare_time(listing(services, reply));
}

void remove(Services& services, const LatticeName& params, const Reply<LatticeList>& reply) {
  services.lattices.remove(params.name, [&services, reply](const Result<void>& done) {
    if (!done) return reply(done.error());
    services.keeper.ask(listing(services, reply));
  });
}

/// Checks the names: each only once, and no more lattices than may be kept.
Result<void> check_names(const LatticePrepare& asked, const PreparedLattices::All& prepared) {
  std::set<std::string> names;
  for (const LatticeRequest& request : asked.lattices) {
    if (names.insert(request.name).second) continue;
    return fail(Errc::invalid, "lattices", "the name \"" + request.name + "\" is given twice");
  }
  for (const auto& [name, lattice] : prepared) names.insert(name);
  if (names.size() <= kMaxLattices) return {};
  return fail(Errc::refused, "lattices",
              fmt::format("at most {} lattices may be prepared, and these would make {}: remove "
                          "some with lattice.remove",
                          kMaxLattices, names.size()));
}

/// The key of request `k` that an error of the sensor's check is about.
std::string field_of(std::size_t k, const std::string& field) {
  const std::string request = fmt::format("lattices[{}].sensor", k);
  if (field.empty() || field.starts_with("beams[")) return request;  // not a key of the sensor
  const std::size_t section = field.find('.');
  return request + "." + (section == std::string::npos ? field : field.substr(section + 1));
}

Result<void> check_requests(const LatticePrepare& asked, const SensorEdit& now) {
  for (std::size_t k = 0; k < asked.lattices.size(); ++k) {
    auto checked = check_request(asked.lattices[k], asked.calibrate, now);
    if (checked) continue;
    Error error = checked.error();
    error.field = field_of(k, error.field);
    return fail(std::move(error));
  }
  return {};
}

Result<Json> measure_lattices(const Services& services, Bench& bench, const LatticePrepare& asked) {
  return prepare_lattices(bench, asked, services.lattices);
}

void prepare(Services& services, const LatticePrepare& asked, const Reply<JobNumber>& reply) {
  if (auto named = check_names(asked, services.lattices.all()); !named) return reply(named.error());
  services.keeper.ask([&services, asked, reply](const SensorEdit& now) {
    if (auto good = check_requests(asked, now); !good) return reply(good.error());
    run<kLatticePrepare, measure_lattices>(services, asked, reply);
  });
}

/// An error about keys of sensor or camera, which the request does not have, as one about its
/// lattice.
Error about_name(Error error) {
  if (!error.field.empty() && error.field != "camera") error.field = "name";
  return error;
}

/// Exposure and gain of `wanted`, as far as they differ from those in use.
CameraSet exposure_change(const CameraSettings& now, const PreparedLattice& wanted) {
  CameraSet change;
  const auto set = [&](double CameraSettings::*member, double value) {
    if (!std::isnan(value) && now.*member != value) change.put(member, value);
  };
  set(&CameraSettings::exposure_us, wanted.exposure_us);
  set(&CameraSettings::gain_db, wanted.gain_db);
  set(&CameraSettings::gain_raw, wanted.gain_raw);
  return change;
}

/// Changes the sensor. If that fails, the camera's settings `before` return before the answer.
void show_lattice(Services& services, const PreparedLattice& lattice, const CameraSet& before,
                  const Reply<LatticeInUse>& reply) {
  const auto shown = [&services, name = lattice.name, before,
                      reply](const Result<SensorView>& now) {
    if (now) {
      return reply(LatticeInUse{name, (*now)->subapertures,
                                services.camera.snapshot().settings.exposure_us,
                                (*now)->hologram_id});
    }
    const Error error = about_name(now.error());
    if (before.given().empty()) return reply(error);
    services.camera.restore(before, [reply, error] { reply(error); });
  };
  services.keeper.edit(use_lattice(lattice), shown);
}

/// The exposure changes first: no settled frame of the lattice then has another one.
void expose_and_show(Services& services, const PreparedLattice& lattice,
                     const Reply<LatticeInUse>& reply) {
  const CameraSnapshot camera = services.camera.snapshot();
  const CameraSet change = exposure_change(camera.settings, lattice);
  if (change.given().empty()) return show_lattice(services, lattice, {}, reply);
  services.camera.change(change, [&services, lattice, back = camera.undo_of(change),
                                  reply](const Result<CameraSnapshot>& set) {
    if (!set) return reply(about_name(set.error()));
    show_lattice(services, lattice, back, reply);
  });
}

/// Nothing comes between its two changes, because the request has a lease of both.
void use(Services& services, const LatticeName& params, const Reply<LatticeInUse>& reply) {
  const auto lattice = services.lattices.find(params.name);
  if (!lattice) return reply(lattice.error());
  reply.begin_lease([&services, lattice = **lattice, reply] {
    services.keeper.ask([&services, lattice, reply](const SensorEdit& now) {
      SensorEdit edit = now;
      auto usable = use_lattice(lattice)(edit);
      if (!usable) return reply(about_name(usable.error()));
      expose_and_show(services, lattice, reply);
    });
  });
}

constexpr std::array kLatticeRows{
    row<kLatticeList, list>(Role::read, Request::read),
    row<kLatticePrepare, prepare>(Role::control, Request::run_hologram_job),
    row<kLatticeRemove, remove>(Role::control, Request::act),
    row<kLatticeUse, use>(Role::control, Request::use_lattice),
};

}  // namespace

std::span<const MethodRow> lattice_methods() {
  return kLatticeRows;
}

}  // namespace ovws
