/// The metrics over HTTP, for Prometheus to come and read.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws::metrics {

/// Why metrics may not be served at this "ADDRESS:PORT": Errc::invalid (field "--listen") for what
/// is no address, and for one that other machines reach, for whoever reads metrics needs no key.
Result<void> check_address(const std::string& address);

/// Answers GET /metrics with the newest messages that it was given, from threads of its library's.
class Exporter {
 public:
  /// Errors as of check_address; Errc::unavailable if the address cannot be had.
  static Result<Exporter> serve(const std::string& address);
  Exporter(Exporter&&) noexcept;
  Exporter& operator=(Exporter&&) noexcept;
  ~Exporter();

  /// The JSON of a status or wavefront message, received now; other topics are nothing to it. A
  /// status counts for some seconds, a wavefront for some frames: then they are no longer told.
  void take(const std::string& topic, std::string message);

 private:
  struct Impl;
  explicit Exporter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::metrics
