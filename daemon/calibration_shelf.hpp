/// The calibrations that are known: one a key, in memory and on the disk.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/calibration.hpp"
#include "daemon/daemon_store.hpp"
#include "daemon/events.hpp"
#include "daemon/reference_origin.hpp"

namespace ovws {

/// One thread at a time, but for what the store allows. Waits for the disk.
class CalibrationShelf {
 public:
  /// As many are kept, of whatever sensor and bench; the oldest goes first.
  static constexpr std::size_t kMost = 16;

  /// `bench` is borrowed.
  CalibrationShelf(const ReferenceBench& bench, DaemonStore& store, Events& events)
      : bench_(bench), store_(store), events_(events) {}

  /// Those on the disk that this bench can use. An event says of each when it was taken and its
  /// checksum, and why, if it is not used; then it stays on the disk.
  void load();
  /// Of those that were not used for the LUT or the flatness alone the ones that belong to those of
  /// now, each once.
  void load_again();
  /// Null: none belongs to `key`.
  std::shared_ptr<const Calibration> find(const CalibrationKey& key) const;
  /// Why none does, by what the likeliest one lacks, and the way out; for a person.
  std::string why_none(const CalibrationKey& key) const;

  /// In place of what else belongs to its key. What the disk does not keep, which an event says, is
  /// kept in memory all the same.
  void put(Calibration calibration);
  /// Of this key, from memory and disk. Errors: it is still on the disk, and in memory.
  Result<void> drop(const CalibrationKey& key);

 private:
  struct Kept {
    std::int64_t t_taken_ns = 0;
    std::string name;
  };
  void load_those(const std::function<bool(const std::string&)>& wanted);
  void use(const StateItem& item);
  void forget(const std::string& name);
  void keep(Calibration& calibration);
  Result<void> drop_file(const std::string& name);
  void drop_oldest();

  const ReferenceBench& bench_;
  DaemonStore& store_;
  Events& events_;
  std::vector<std::shared_ptr<const Calibration>> all_;  ///< oldest first
  std::vector<Kept> kept_;                               ///< whole files, used or not
  std::map<std::string, nlohmann::json> aside_;  ///< by name, the SLM of those to load again
};

}  // namespace ovws
