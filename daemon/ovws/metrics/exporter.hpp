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

/// Checks that metrics may be served at this "ADDRESS:PORT". Errors: Errc::invalid (field
/// "--listen") for a malformed address and for one that other machines can reach, because metrics
/// need no key.
Result<void> check_address(const std::string& address);

/// Serves GET /metrics from the newest messages, in threads of the prometheus-cpp library.
class Exporter {
 public:
  /// Errors: as check_address; Errc::unavailable if the address is not available.
  static Result<Exporter> serve(const std::string& address);
  Exporter(Exporter&&) noexcept;
  ~Exporter();

  /// Stores the JSON of a status or wavefront message, received now; ignores other topics. A status
  /// expires after some seconds, a wavefront after some frames; expired ones give no metrics.
  void take(const std::string& topic, std::string message);

 private:
  Exporter();

  std::shared_ptr<Newest> newest_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace ovws::metrics
