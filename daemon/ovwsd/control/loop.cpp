/// Methods loop.*: the closed loop.
#include "proto/tables/loop.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/loop/closed_loop.hpp"

namespace ovws {
namespace {

void close(Services& services, const LoopSettings& settings, Reply<LoopReport> reply) {
  services.loop.close(settings, reply);
}

void open(Services& services, const LoopOpen& how, Reply<LoopReport> reply) {
  services.loop.open(how.keep, reply);
}

void get(Services& services, Reply<LoopReport> reply) {
  reply(services.loop.report());
}

constexpr std::array kRows{
    row<kLoopClose, close>(Role::control, Action::close_loop),
    row<kLoopOpen, open>(Role::control, Action::open_loop),
    row<kLoopGet, get>(Role::read, Action::read),
};

}  // namespace

std::span<const MethodRow> loop_methods() {
  return kRows;
}

}  // namespace ovws
