/// Methods lattice.*: prepared lattices, and switching between them.
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <set>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/lattices.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/prepared_lattices.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {
namespace {

void list(Services& services, Reply<LatticeList> reply) {
  services.keeper.ask([all = services.lattices.all(), reply](const SensorEdit& now) {
    LatticeList list;
    for (const auto& [name, lattice] : all) list.lattices.push_back(report_of(lattice, now));
    reply(list);
  });
}

void remove(Services& services, const LatticeName& params, Reply<LatticeList> reply) {
  services.lattices.remove(params.name, [&services, reply](const Result<void>& done) {
    if (!done) return reply(done.error());
    list(services, reply);
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

Result<void> check_requests(const LatticePrepare& asked, const SensorEdit& now) {
  for (std::size_t k = 0; k < asked.lattices.size(); ++k) {
    auto checked = check_request(asked.lattices[k], asked.calibrate, now);
    if (checked) continue;
    Error error = checked.error();
    const std::size_t section = error.field.find('.');
    const std::string key =
        section == std::string::npos ? error.field : error.field.substr(section + 1);
    error.field = fmt::format("lattices[{}].sensor{}{}", k, key.empty() ? "" : ".", key);
    return fail(std::move(error));
  }
  return {};
}

void prepare(Services& services, const LatticePrepare& asked, Reply<JobNumber> reply) {
  if (auto named = check_names(asked, services.lattices.all()); !named) return reply(named.error());
  services.keeper.ask([&services, asked, reply](const SensorEdit& now) {
    if (auto good = check_requests(asked, now); !good) return reply(good.error());
    services.procedures.start(
        kLatticePrepare.name,
        [&services, asked](Bench& bench) {
          return prepare_lattices(bench, services.config.slm.geometry, asked, services.lattices);
        },
        with_job_number(reply));
  });
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

/// Switches the sensor. If that fails, the camera's settings `before` return before the reply.
void show(Services& services, const PreparedLattice& lattice, const CameraSet& before,
          Reply<LatticeInUse> reply) {
  const auto done = [&services, lattice, before, reply](const Result<SensorView>& used) {
    if (used) {
      return reply(LatticeInUse{lattice.name, (*used)->subapertures, lattice.exposure_us,
                                (*used)->hologram_id});
    }
    Error error = used.error();
    if (!error.field.empty()) error.field = "name";
    if (before.given().empty()) return reply(error);
    services.camera.change(before, [reply, error](const auto&) { reply(error); });
  };
  services.keeper.edit(Hold::unheld(), use_lattice(lattice), done);
}

/// The exposure changes first: no settled frame of the lattice then has another one.
void use(Services& services, const LatticeName& params, Reply<LatticeInUse> reply) {
  const auto lattice = services.lattices.find(params.name);
  if (!lattice) return reply(lattice.error());
  const CameraSettings now = services.camera.snapshot().settings;
  const CameraSet change = exposure_change(now, *lattice);
  if (change.given().empty()) return show(services, *lattice, {}, std::move(reply));
  CameraSet back;
  for (const auto member :
       {&CameraSettings::exposure_us, &CameraSettings::gain_db, &CameraSettings::gain_raw}) {
    if (change.gives(member)) back.put(member, now.*member);
  }
  services.camera.change(change, [&services, lattice = *lattice, back = std::move(back),
                                  reply](const Result<CameraSnapshot>& set) {
    if (!set) return reply(set.error());
    show(services, lattice, back, reply);
  });
}

constexpr std::array kRows{
    row<kLatticeList, list>(Role::read, Action::read),
    row<kLatticePrepare, prepare>(Role::control, Action::start_hologram_job),
    row<kLatticeRemove, remove>(Role::control, Action::record),
    row<kLatticeUse, use>(Role::control, Action::show_pattern),
};

}  // namespace

std::span<const MethodRow> lattice_methods() {
  return kRows;
}

}  // namespace ovws
