/// References on the disk: kept when they are taken, dropped when they are cleared, found again at
/// the start.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// "the reference of 2026-01-31T12:00:00.000Z"
std::string title_of(const Reference& reference);

/// One thread at a time. Only `load` waits for the disk.
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
  /// In place of those of the names `replaced`, which are dropped when it is kept. `told` in the
  /// disk thread: its checksum, empty if it could not be kept, which an event says; then again, if
  /// it is kept after all.
  void keep(const Reference& reference, const std::vector<std::string>& replaced = {},
            std::function<void(const std::string& sha256)> told = nullptr);
  /// Files of these names. `told` in the disk thread; an error: some are still on the disk.
  void drop(const std::vector<std::string>& names, DaemonStore::Dropped told);

  const ReferenceBench& bench() const { return bench_; }
  /// From now on the bench's LUT and flatness are these.
  void use_slm(const SlmInForce& slm) { bench_.use_slm(slm); }

 private:
  struct Kept {
    std::int64_t t_taken_ns = 0;
    std::string name;
  };
  /// One that was found, and what its file is.
  struct Found {
    std::string name, path;
    Reference reference;
  };
  std::optional<Reference> read(const StateItem& item);
  std::optional<Reference> use(Found found);
  void forget(const std::string& name);
  void drop_oldest();

  ReferenceBench bench_;
  DaemonStore& store_;
  Events& events_;
  std::vector<Kept> kept_;              ///< whole files, used or not
  std::map<std::string, Found> aside_;  ///< by name, those of another LUT or flatness
};

}  // namespace ovws
