/// Methods of an external corrector, which a client drives.
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/streams/corrector.hpp"

namespace ovws {
namespace {

void get_corrector(Services& services, const Reply<KnownCorrector>& reply) {
  reply(services.corrector.report(services.keeper.snapshot()->modes_j));
}

void set_corrector(Services& services, const CorrectorSet& given, std::string matrix,
                   const Reply<KnownCorrector>& reply) {
  const auto set = services.corrector.set(given, matrix, services.keeper.snapshot()->modes_j);
  if (!set) return reply(set.error());
  get_corrector(services, reply);
}

void clear_corrector(Services& services, const Reply<KnownCorrector>& reply) {
  services.corrector.clear();
  get_corrector(services, reply);
}

constexpr std::array kCorrectorRows{
    row<kCorrectorGet, get_corrector>(Role::read, Request::read),
    row<kCorrectorSet, set_corrector>(Role::control, Request::act),
    row<kCorrectorClear, clear_corrector>(Role::control, Request::act),
};

}  // namespace

std::span<const MethodRow> corrector_methods() {
  return kCorrectorRows;
}

}  // namespace ovws
