#include "daemon/ovwsd/access/client_guard.hpp"

#include <sys/stat.h>

#include <chrono>
#include <exception>
#include <string>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/shared/key_file.hpp"
#include "proto/endpoint.hpp"

namespace ovws {
namespace {

constexpr const char* kSecretField = "security.secret_key";
constexpr const char* kClientsField = "security.clients";
constexpr std::int64_t kCheckNs = 1'000'000'000;
constexpr std::chrono::milliseconds kCheckTimeout{100};
constexpr std::int64_t kReportNs = 10'000'000'000;

template <class T>
Result<T> named(Result<T> result, const char* field) {
  if (result) return result;
  Error error = result.error();
  if (error.field != "path") error.reason = text_of(error);
  error.field = field;
  return fail(std::move(error));
}

Result<void> check_endpoint(const char* field, const std::string& endpoint) {
  if (is_reached_from_here_only(endpoint)) return {};
  return fail(Errc::invalid, field,
              "other machines can reach " + endpoint +
                  " without authentication: bind tcp://127.0.0.1:PORT or ipc://PATH, or set "
                  "security.secret_key and security.clients (ovws keygen makes keys)");
}

std::int64_t ns_of(const timespec& time) {
  return std::int64_t(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

Result<void> check_clients(const std::string& path) {
  const auto list = named(load_client_list(path), kClientsField);
  if (!list) return fail(list.error());
  return {};
}

Result<void> check_security(const Config& config) {
  if (config.security.secret_key && config.security.clients) {
    auto keys = named(load_key_file(*config.security.secret_key), kSecretField);
    if (!keys) return fail(keys.error());
    return check_clients(*config.security.clients);
  }
  const std::pair<const char*, const std::string&> endpoints[]{
      {"control.endpoint", config.control.endpoint},
      {"stream.endpoint", config.stream.endpoint},
      {"stream.image_endpoint", config.stream.image_endpoint}};
  for (const auto& [field, endpoint] : endpoints) {
    if (auto safe = check_endpoint(field, endpoint); !safe) return safe;
  }
  return {};
}

ClientGuard::ClientGuard(SecurityConfig config, Counters& counters, Events& events, Disk& disk)
    : config_(std::move(config)),
      counters_(counters),
      events_(events),
      disk_(disk),
      list_(std::make_shared<const ClientList>()) {}

Result<std::unique_ptr<ClientGuard>> ClientGuard::make(const SecurityConfig& config,
                                                       Counters& counters, Events& events,
                                                       Disk& disk) {
  std::unique_ptr<ClientGuard> guard(new ClientGuard(config, counters, events, disk));
  if (!config.secret_key || !config.clients) return guard;
  const auto keys = named(load_key_file(*config.secret_key), kSecretField);
  if (!keys) return fail(keys.error());
  auto made =
      Gate::make(keys->pair.secret_key,
                 {[self = guard.get()](const std::string& key) {
                    self->check_file_first();
                    return self->knows(key);
                  },
                  [self = guard.get()](const std::string& why) { self->reject(why); },
                  [self = guard.get()](const std::string& endpoint, const Result<void>& bound) {
                    self->report_rebound(endpoint, bound);
                  }});
  if (!made) return fail(made.error());
  guard->gate_ = std::move(*made);
  guard->public_key_ = keys->pair.public_key;
  if (auto read = guard->read_list(); !read) return fail(read.error());
  return guard;
}

Result<Role> ClientGuard::role_of(const std::string& key) {
  if (!gate_) return Role::control;
  check_file_first();
  const auto list = list_.get();
  const auto found = list->find(key);
  if (found != list->end()) return found->second.role;
  reject("a request came with the withdrawn key " + key);
  return fail(Errc::refused, "", "this client's key is no longer in the file of security.clients");
}

bool ClientGuard::knows(const std::string& key) const {
  return list_.get()->contains(key);
}

void ClientGuard::reject(const std::string& why) {
  counters_.add(Counter::clients_rejected);
  rejected_.change([&why](Rejected& rejected) {
    ++rejected.count;
    rejected.why = why;
  });
}

ClientGuard::Stamp ClientGuard::stamp_of(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return {};
  return {ns_of(about.st_mtim), ns_of(about.st_ctim), about.st_size, about.st_ino};
}

void ClientGuard::report_rebound(const std::string& endpoint, const Result<void>& bound) {
  if (bound) {
    return events_.emit("client", Severity::info, "the stream at " + endpoint + " is open again",
                        {{"endpoint", endpoint}, {"bound", true}});
  }
  events_.emit(
      "client", Severity::error,
      "after a key was withdrawn, " + endpoint +
          " cannot be bound again and publishes nothing; retrying: " + bound.error().reason,
      {{"endpoint", endpoint}, {"bound", false}, {"reason", bound.error().reason}});
}

/// Reads the client file. Takes the file's stamp first, so that a file that is written during the
/// read is read again.
Result<void> ClientGuard::read_list() {
  stamp_ = stamp_of(*config_.clients);
  auto read = named(load_client_list(*config_.clients), kClientsField);
  if (!read) return fail(read.error());
  const auto before = list_.get();
  list_.set(std::make_shared<const ClientList>(*read));
  for (const auto& [key, client] : *before) {
    if (!read->contains(key)) {
      gate_->end_streams();
      break;
    }
  }
  return {};
}

/// Requests a check of the client file, and returns the number of the request.
std::uint64_t ClientGuard::request_check() {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(check_mutex_);
    number = ++checks_requested_;
  }
  disk_.post([this] { check_file(); });
  return number;
}

/// Waits until the disk thread has checked the client file, for kCheckTimeout at most. Does not
/// wait while an earlier check is late.
void ClientGuard::check_file_first() {
  {
    const std::lock_guard lock(check_mutex_);
    if (late_) return;
  }
  const std::uint64_t number = request_check();
  std::unique_lock lock(check_mutex_);
  late_ = !checked_.wait_for(lock, kCheckTimeout, [&] { return checks_done_ >= number; });
}

/// Disk thread: checks the client file, and answers all requests made so far.
void ClientGuard::check_file() {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(check_mutex_);
    number = checks_requested_;
  }
  try {
    reload_if_changed();
  } catch (const std::exception& error) {  // still count as answered, else no check is made again
    events_.emit("client", Severity::error,
                 std::string("the client list could not be checked: ") + error.what());
  }
  {
    const std::lock_guard lock(check_mutex_);
    checks_done_ = number;
    late_ = false;
  }
  checked_.notify_all();
}

void ClientGuard::reload_if_changed() {
  if (stamp_of(*config_.clients) == stamp_) return;
  if (const auto read = read_list(); !read) {
    return events_.emit("client", Severity::error,
                        text_of(read.error()) + "; the previous client list stays active");
  }
  events_.emit("client", Severity::info,
               *config_.clients + " was read again: " + std::to_string(list_.get()->size()) +
                   " clients may connect");
}

void ClientGuard::turn() {
  if (!gate_) return;
  const std::int64_t now_ns = monotonic_ns();
  if (now_ns >= next_check_ns_) {
    next_check_ns_ = now_ns + kCheckNs;
    const bool answered = [this] {
      const std::lock_guard lock(check_mutex_);
      return checks_done_ == checks_requested_;
    }();
    if (answered) request_check();
  }
  if (now_ns >= next_report_ns_) report_rejected();
}

void ClientGuard::report_rejected() {
  const Rejected rejected =
      rejected_.change([](Rejected& now) { return std::exchange(now, Rejected{}); });
  if (rejected.count == 0) return;
  next_report_ns_ = monotonic_ns() + kReportNs;
  const std::string times =
      rejected.count == 1 ? "" : std::to_string(rejected.count) + " times, most recently: ";
  events_.emit("client", Severity::warning, "client rejected: " + times + rejected.why,
               {{"rejected", rejected.count}, {"reason", rejected.why}});
}

}  // namespace ovws
