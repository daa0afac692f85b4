#include "daemon/ovwsd/lease/leases.hpp"

#include <algorithm>
#include <utility>

namespace ovws {
namespace {

bool meet(Request a, Request b) {
  return (row_of(a).parts & row_of(b).parts) != part::kNone;
}

bool is_clients(Request request) {
  return row_of(request).holder == Holder::client;
}

}  // namespace

Leases::~Leases() {
  std::vector<Entry> dropped;  // what waits may hold leases, which end here
  const std::lock_guard lock(mutex_);
  dropped.swap(entries_);
}

Result<LeasePtr> Leases::take(Request request) {
  const RequestRow& row = row_of(request);
  const std::lock_guard lock(mutex_);
  if (auto can = check_needs(conditions_, fixed_, row.needs); !can) return fail(can.error());
  for (const Entry& other : entries_) {
    // A client's change ends soon: `begin` waits for it.
    if (is_clients(other.request) || !meet(request, other.request)) continue;
    return fail(Errc::refused, "", std::string(refusal_of(row_of(other.request).holder)));
  }
  if (row.parts == part::kNone) return LeasePtr();
  entries_.push_back({++last_id_, request});
  return std::make_shared<Lease>(*this, last_id_, row.parts);
}

void Leases::begin(std::uint64_t id, std::function<void()> then) {
  const auto waiting = std::make_shared<std::function<void()>>(std::move(then));
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find(entries_, id, &Entry::id);
  if (at == entries_.end() || at->waiting || at->begun) return;
  at->waiting = waiting;
  if (is_alone(*at)) start(*at);
}

void Leases::end(std::uint64_t id) {
  // Destroyed after the unlock: what waits may hold leases.
  std::vector<std::shared_ptr<std::function<void()>>> kept;
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find(entries_, id, &Entry::id);
  if (at == entries_.end()) return;
  const DaemonState before = state();
  const Holder holder = sensors_holder();
  kept.push_back(std::move(at->waiting));
  entries_.erase(at);
  if (sensors_holder() != holder) turn_(sensors_holder(), nullptr);
  publish(before);
  for (Entry& entry : entries_) {
    if (!entry.waiting || !is_alone(entry)) continue;
    kept.push_back(entry.waiting);
    start(entry);
  }
}

/// Whether no client's change of the entry's parts is under way.
bool Leases::is_alone(const Entry& entry) const {
  return std::ranges::none_of(entries_, [&entry](const Entry& other) {
    return is_clients(other.request) && meet(entry.request, other.request);
  });
}

/// Call with mutex_ locked, and with a copy of entry.waiting that is destroyed after the unlock.
void Leases::start(Entry& entry) {
  const DaemonState before = state();
  entry.begun = true;
  turn_(sensors_holder(), [then = std::exchange(entry.waiting, nullptr)] { (*then)(); });
  publish(before);
}

/// Who has the sensor for longer than a client's change.
Holder Leases::sensors_holder() const {
  for (const Entry& entry : entries_) {
    const RequestRow& row = row_of(entry.request);
    if (entry.begun && (row.parts & part::kSensor) != part::kNone) return row.holder;
  }
  return Holder::nobody;
}

DaemonState Leases::state() const {
  if (conditions_.stopping) return DaemonState::stopping;
  if (!conditions_.started) return DaemonState::starting;
  if (conditions_.fault) return DaemonState::fault;
  if (!conditions_.camera) return DaemonState::waiting_for_camera;
  if (!conditions_.display) return DaemonState::waiting_for_display;
  return sensors_holder() == Holder::job ? DaemonState::job_running : DaemonState::running;
}

void Leases::set(bool Conditions::*condition, bool holds) {
  const std::lock_guard lock(mutex_);
  const DaemonState before = state();
  conditions_.*condition = holds;
  publish(before);
}

void Leases::set_device(const std::string& device, bool Conditions::*condition, bool connected,
                        const std::string& cause) {
  const std::lock_guard lock(mutex_);
  const DaemonState before = state();
  conditions_.*condition = connected;
  if (cause.empty()) {
    causes_.erase(device);
  } else {
    causes_[device] = cause;
  }
  conditions_.fault = !causes_.empty();
  publish(before);
}

Leases::Report Leases::report() const {
  const std::lock_guard lock(mutex_);
  Report now{state(), std::nullopt};
  for (const auto& [device, cause] : causes_) {
    now.fault = (now.fault ? *now.fault + "; " : "") + device + ": " + cause;
  }
  return now;
}

/// Emits an event if the state is not `before` any more. Call with mutex_ locked, so that events of
/// different threads keep their order.
void Leases::publish(DaemonState before) {
  const DaemonState now = state();
  if (now == before) return;
  const std::string name(state_name(now));
  const auto severity = now == DaemonState::fault ? Severity::error : Severity::info;
  events_.emit("state", severity, "state is " + name,
               {{"state", name}, {"before", state_name(before)}});
}

bool Leases::has_bench() const {
  const std::lock_guard lock(mutex_);
  return conditions_.camera && conditions_.display;
}

}  // namespace ovws
