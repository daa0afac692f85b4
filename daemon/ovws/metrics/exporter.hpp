/// HTTP exporter of the metrics, for Prometheus to scrape.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace prometheus {
class Exposer;
}

namespace ovws::metrics {

class Newest;

/// Checks that metrics may be served at `address`, "ADDRESS:PORT". Errc::invalid (field
/// "--listen"): the address is malformed, or other machines can reach it. Metrics need no key, so
/// only this machine may read them.
Result<void> check_address(const std::string& address);

/// Whether a request with this Host header is answered: "localhost" or a loopback address, with or
/// without a port. A web page of another host name that was made to mean this machine (DNS
/// rebinding) must not read the metrics.
bool is_host_of_this_machine(const std::string& host);

/// Serves GET /metrics from the newest messages, in threads of the prometheus-cpp library.
class Exporter {
 public:
  /// Starts the HTTP server. Errors: see check_address; Errc::unavailable if the address is not
  /// available.
  static Result<Exporter> serve(const std::string& address);
  Exporter(Exporter&&) noexcept;
  ~Exporter();

  /// Stores a status or wavefront message (JSON) with the present time; ignores other topics. Old
  /// messages give no metrics (proto/message_age.hpp).
  void take(const std::string& topic, std::string message);

 private:
  Exporter();

  std::shared_ptr<Newest> newest_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace ovws::metrics
