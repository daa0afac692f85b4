/// The calibrations that are known: one a key, in memory and on the disk.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// One thread at a time. Only `load` waits for the disk.
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
  /// kept in memory all the same. `told` in the disk thread: its checksum, empty if it could not be
  /// kept; then again, if it is kept after all.
  void put(Calibration calibration, std::function<void(const std::string& sha256)> told = nullptr);
  /// The same calibration with the checksum of its file; null: it is not known any more.
  std::shared_ptr<const Calibration> know_file(std::int64_t t_taken_ns, const std::string& sha256);
  /// Takes those of this key out of memory.
  std::vector<std::shared_ptr<const Calibration>> take(const CalibrationKey& key);
  void put_back(const std::vector<std::shared_ptr<const Calibration>>& taken);
  /// Their files; `told` in the disk thread; an error: some are still on the disk.
  void drop_files(const std::vector<std::shared_ptr<const Calibration>>& taken,
                  DaemonStore::Dropped told);

 private:
  struct Kept {
    std::int64_t t_taken_ns = 0;
    std::string name;
  };
  /// One that was found, and what its file is.
  struct Found {
    std::string name, path;
    Calibration calibration;
  };
  void read(const StateItem& item);
  void use(Found found);
  void sort_by_age();
  void forget(const std::string& name);
  void drop_oldest();

  const ReferenceBench& bench_;
  DaemonStore& store_;
  Events& events_;
  std::vector<std::shared_ptr<const Calibration>> all_;  ///< oldest first
  std::vector<Kept> kept_;                               ///< whole files, used or not
  std::map<std::string, Found> aside_;  ///< by name, those of another LUT or flatness
};

}  // namespace ovws
