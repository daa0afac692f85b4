/// References on the disk: kept when they are taken, dropped when they are cleared, found again at
/// the start.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/daemon_store.hpp"
#include "daemon/events.hpp"
#include "daemon/reference.hpp"
#include "daemon/reference_origin.hpp"

namespace ovws {

/// "the reference of 2026-01-31T12:00:00.000Z"
std::string title_of(const Reference& reference);

/// One thread at a time, but for what the store allows. Waits for the disk.
class ReferenceArchive {
 public:
  /// As many are kept, of whatever sensor and bench; the oldest goes first.
  static constexpr std::size_t kMostKept = 16;

  ReferenceArchive(ReferenceBench bench, DaemonStore& store, Events& events)
      : bench_(std::move(bench)), store_(store), events_(events) {}

  /// Those that this bench can use, oldest first. An event says of each that was found when it was
  /// taken and its checksum, and why, if it is not used; then it stays on the disk.
  std::vector<Reference> load();
  /// Of those that were not used for the LUT or the flatness alone the ones that belong to those of
  /// now, each once.
  std::vector<Reference> load_again();
  /// Sets `reference.sha256`; empty if it could not be kept, which an event says.
  void keep(Reference& reference);
  /// Errors: it is still on the disk.
  Result<void> drop(const Reference& reference);

  const ReferenceBench& bench() const { return bench_; }
  /// From now on the bench's LUT and flatness are these.
  void use_slm(const SlmInForce& slm) { bench_.use_slm(slm); }

 private:
  struct Kept {
    std::int64_t t_taken_ns = 0;
    std::string name;
  };
  std::vector<Reference> load_those(const std::function<bool(const std::string&)>& wanted);
  std::optional<Reference> use(const StateItem& item);
  void forget(const std::string& name);
  void drop_oldest();

  ReferenceBench bench_;
  DaemonStore& store_;
  Events& events_;
  std::vector<Kept> kept_;                       ///< whole files, used or not
  std::map<std::string, nlohmann::json> aside_;  ///< by name, the SLM of those to load again
};

}  // namespace ovws
