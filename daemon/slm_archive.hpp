/// What was measured of the SLM, on the disk: kept when it is measured, dropped when it is cleared,
/// found again at the start.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "daemon/daemon_store.hpp"
#include "daemon/events.hpp"
#include "daemon/slm_measured.hpp"

namespace ovws {

/// One thread at a time, but for what the store allows. Waits for the disk.
class SlmArchive {
 public:
  SlmArchive(const Config& config, DaemonStore& store, Events& events)
      : config_(config), store_(store), events_(events) {}

  /// What was kept of an SLM of this size and pitch at this wavelength; null: nothing. An event
  /// says when it was measured and its checksum, or why it is not used.
  std::shared_ptr<const MeasuredLut> load_lut();
  std::shared_ptr<const MeasuredFlatness> load_flatness();
  /// Set `sha256`. What cannot be kept an event says; then it is empty.
  void keep(MeasuredLut& lut);
  void keep(MeasuredFlatness& flatness);
  /// Errors: it is still on the disk.
  Result<void> drop_lut();
  Result<void> drop_flatness();

 private:
  template <class T, class Read>
  std::shared_ptr<const T> load(const char* kind, const Read& read);
  template <class T>
  void keep(const char* kind, T& measured, const nlohmann::json& content);
  std::string obstacle(const nlohmann::json& origin) const;

  Config config_;
  DaemonStore& store_;
  Events& events_;
};

}  // namespace ovws
