/// What was measured of the SLM, on the disk: kept when it is measured, dropped when it is cleared,
/// found again at the start.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// One thread at a time. Only loading waits for the disk.
class SlmArchive {
 public:
  /// `configured`: with the flatness of the configuration's file.
  SlmArchive(const Config& config, const HologramConfig& configured, DaemonStore& store,
             Events& events)
      : config_(config), configured_(flatness_sha256(configured)), store_(store), events_(events) {}

  /// What was kept of an SLM of this size and pitch at this wavelength; a flatness only with the
  /// same file and the same optics. Null: nothing. An event says when it was measured and its
  /// checksum, or why it is not used.
  std::shared_ptr<const MeasuredLut> load_lut();
  std::shared_ptr<const MeasuredFlatness> load_flatness();
  /// `told` in the disk thread: the checksum, empty if it could not be kept, which an event says;
  /// then again, if it is kept after all.
  using Told = std::function<void(const std::string& sha256)>;
  void keep(const MeasuredLut& lut, Told told = nullptr);
  void keep(const MeasuredFlatness& flatness, Told told = nullptr);
  /// `told` in the disk thread; an error: it is still on the disk.
  void drop_lut(DaemonStore::Dropped told);
  void drop_flatness(DaemonStore::Dropped told);

 private:
  template <class T, class Read>
  std::shared_ptr<const T> load(const char* kind, const Read& read);
  template <class T>
  void keep(const char* kind, const T& measured, const nlohmann::json& content, Told told);
  std::string obstacle(const nlohmann::json& origin) const;
  std::string obstacle(const MeasuredLut& lut) const { return obstacle(lut.origin); }
  std::string obstacle(const MeasuredFlatness& flatness) const;

  Config config_;
  nlohmann::json configured_;  ///< checksum of the file's flatness, or null
  DaemonStore& store_;
  Events& events_;
};

}  // namespace ovws
