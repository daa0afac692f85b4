#include "daemon/ovws/metrics/exporter.hpp"

#include <CivetServer.h>
#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <chrono>
#include <exception>
#include <mutex>

#include "daemon/ovws/metrics/families.hpp"
#include "proto/endpoint.hpp"
#include "proto/json_text.hpp"
#include "proto/message_age.hpp"

namespace ovws::metrics {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr const char* kField = "--listen";

/// A message as received; parsed only when metrics are requested.
struct Received {
  std::string text;
  Clock::time_point at;

  double age_s() const { return std::chrono::duration<double>(Clock::now() - at).count(); }
  std::optional<json> read() const {
    json message = json_of(text);
    return message.is_object() ? std::optional(std::move(message)) : std::nullopt;
  }
};

/// Called before each request is answered. 0: answer it.
int refuse_foreign_host(mg_connection* connection) {
  constexpr int kForbidden = 403;
  const char* const host = mg_get_header(connection, "Host");
  if (host != nullptr && is_host_of_this_machine(host)) return 0;
  mg_send_http_error(connection, kForbidden, "%s",
                     "address this exporter as localhost or by a loopback address");
  return kForbidden;
}

}  // namespace

/// Newest messages: every scrape by Prometheus makes its metrics from the stored messages.
/// Thread-safe.
class Newest : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override {
    const auto [status, wavefront] = newest();
    const auto recent_status = status.age_s() < kStatusMaxAgeS ? status.read() : std::nullopt;
    const bool current = recent_status && wavefront.age_s() < wavefront_max_age_s(*recent_status);
    return families(recent_status, current ? wavefront.read() : std::nullopt);
  }

  void take(const std::string& topic, Received message) {
    const std::lock_guard lock(mutex_);
    if (topic == "status") status_ = std::move(message);
    if (topic == "wavefront") wavefront_ = std::move(message);
  }

 private:
  std::pair<Received, Received> newest() const {
    const std::lock_guard lock(mutex_);
    return {status_, wavefront_};
  }

  mutable std::mutex mutex_;
  Received status_, wavefront_;
};

Exporter::Exporter() : newest_(std::make_shared<Newest>()) {}
Exporter::Exporter(Exporter&&) noexcept = default;
Exporter::~Exporter() = default;

Result<void> check_address(const std::string& address) {
  const std::string endpoint = "tcp://" + address;
  if (bind_fault(endpoint)) {
    return fail(
        Errc::invalid, kField,
        "\"" + address + "\" is not ADDRESS:PORT with a numeric address, e.g. 127.0.0.1:7705");
  }
  if (is_reached_from_here_only(endpoint)) return {};
  return fail(
      Errc::invalid, kField,
      "other machines could read " + address +
          " without a key: use a numeric loopback address, e.g. 127.0.0.1:7705; for another "
          "machine run ovws --key FILE --endpoint tcp://HOST:7702 metrics there");
}

bool is_host_of_this_machine(const std::string& host) {
  const auto colon = host.rfind(':');
  const bool has_port = colon != std::string::npos && host.find(']', colon) == std::string::npos;
  return host.substr(0, has_port ? colon : host.npos) == "localhost" ||
         is_reached_from_here_only("tcp://" + host + (has_port ? "" : ":80"));
}

Result<Exporter> Exporter::serve(const std::string& address) {
  if (auto right = check_address(address); !right) return fail(right.error());
  Exporter exporter;
  CivetCallbacks callbacks;
  callbacks.begin_request = refuse_foreign_host;
  try {
    // The request timeout limits how long an idle connection occupies a thread.
    exporter.exposer_ = std::make_unique<prometheus::Exposer>(
        std::vector<std::string>{"listening_ports", address, "num_threads", "16",
                                 "request_timeout_ms", "2000"},
        &callbacks);
    exporter.exposer_->RegisterCollectable(exporter.newest_);
  } catch (const std::exception&) {
    return fail(Errc::unavailable, kField,
                "cannot listen on " + address + ": is the address in use by another program?");
  }
  return exporter;
}

void Exporter::take(const std::string& topic, std::string message) {
  newest_->take(topic, {std::move(message), Clock::now()});
}

}  // namespace ovws::metrics
