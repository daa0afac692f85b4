/// Presentations: pictures of a client, shown in place of the sensor for as long as the client
/// renews its lease (slm.present).
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "proto/tables/picture.hpp"

namespace ovws {

/// Largest binary frame of slm.present for this SLM, bytes.
std::size_t max_picture_bytes(const SlmGeometry& slm);

/// The presentation that runs, if any. It is a job that holds the hologram; its thread shows the
/// pictures in the order of the requests. Thread-safe.
class Presentations {
 public:
  using Done = std::function<void(Result<PresentReport>)>;

  Presentations(Leases& leases, Procedures& procedures, const SlmGeometry& slm)
      : leases_(leases), procedures_(procedures), slm_(slm) {}

  /// Carries out slm.present; `bytes` is the picture, empty if there is none. `done` is called in
  /// any thread, when the SLM has settled. Errors: Errc::invalid, of shape, size or pixels;
  /// Errc::refused, the job is not a presentation that runs; those of Leases::take and
  /// Bench::show, and Errc::unavailable, too little memory: the presentation goes on, or ends if
  /// this was its first picture.
  void present(const SlmPresent& wish, std::string bytes, Done done);

 private:
  struct Show;
  Result<void> check(const SlmPresent& wish, const std::string& bytes) const;
  void begin(std::function<void(const std::shared_ptr<Show>&)> order, Done done);
  void end(Show& show);
  Result<nlohmann::json> run(Bench& bench, const std::shared_ptr<Show>& show);

  Leases& leases_;
  Procedures& procedures_;
  const SlmGeometry slm_;
  std::mutex mutex_;
  std::shared_ptr<Show> running_;  ///< null: no presentation takes orders
};

}  // namespace ovws
