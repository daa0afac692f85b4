#include "daemon/calibration_shelf.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>

#include "core/optics/lattice.hpp"
#include "daemon/calibration_file.hpp"
#include "daemon/mode_operators.hpp"
#include "daemon/store/encoding.hpp"
#include "proto/results.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "calibration";
constexpr const char* kRun = "run calibration.run";

std::string title_of(const MeasuredCalibration& calibration) {
  return "the calibration of " + utc_text(calibration.t_taken_ns);
}

/// The same for calibrations of one bench, camera, sensor, tracking, region and registration.
std::string name_of(const json& origin) {
  return sha256_hex(identity_of(origin) + origin["registration"].dump()).substr(0, 16);
}

/// As it was when it was measured, whatever the model says by now.
Result<MatrixComparison> compared(const Calibration& calibration, const SlmGeometry& slm) {
  const ReferenceKey& key = calibration.key.sensor;
  const auto lattice = make_lattice(key.sensor, slm);
  if (!lattice) return fail(lattice.error());
  return compare(calibration.matrix,
                 slope_operator(*lattice, key.sensor, key.tracking, calibration.key.px_per_cycle));
}

}  // namespace

void CalibrationShelf::load() {
  load_those([](const std::string&) { return true; });
}

void CalibrationShelf::load_again() {
  std::set<std::string> names;
  for (const auto& [name, slm] : aside_) {
    if (slm == bench_.slm()) names.insert(name);
  }
  if (!names.empty()) load_those([&](const std::string& name) { return names.contains(name); });
}

void CalibrationShelf::load_those(const std::function<bool(const std::string&)>& wanted) {
  store_.load(kKind, [&](const StateItem& item) {
    if (wanted(item.name)) use(item);
  });
  std::sort(all_.begin(), all_.end(),
            [](const auto& a, const auto& b) { return a->t_taken_ns < b->t_taken_ns; });
}

void CalibrationShelf::use(const StateItem& item) {
  json data{{"path", item.path}, {"sha256", item.sha256}, {"used", false}};
  auto calibration = calibration_from(item.content, bench_.config());
  if (!calibration) {
    const Error& why = calibration.error();
    events_.emit(
        "calibration", Severity::warning,
        fmt::format("{} is not used, and left as it is: {} {}", item.path, why.field, why.reason),
        std::move(data));
    return;
  }
  forget(item.name);
  kept_.push_back({calibration->t_taken_ns, item.name});
  calibration->sha256 = item.sha256;
  data["t_taken_ns"] = calibration->t_taken_ns;
  const std::string found =
      fmt::format("{} ({}, sha256 {})", title_of(*calibration), item.path, item.sha256);
  std::string obstacle = bench_.obstacle(*calibration->origin, calibration->key.sensor,
                                         std::size_t(calibration->matrix.spots()));
  if (obstacle.empty()) {
    auto comparison = compared(*calibration, bench_.config().slm.geometry);
    if (comparison) calibration->comparison = std::move(*comparison);
    if (!comparison) obstacle = comparison.error().reason;
  }
  data["used"] = obstacle.empty();
  if (!obstacle.empty()) {
    const json& origin = *calibration->origin;
    if (bench_.has_other_slm_only(origin)) aside_[item.name] = origin["slm"];
    events_.emit("calibration", Severity::warning, found + " is not used: " + obstacle,
                 std::move(data));
    return;
  }
  events_.emit("calibration", Severity::info, found + " is found again", std::move(data));
  all_.push_back(std::make_shared<const Calibration>(std::move(*calibration)));
}

/// The one taken last, if several belong: those of two cameras, while which is in use is not known.
std::shared_ptr<const Calibration> CalibrationShelf::find(const CalibrationKey& key) const {
  const auto found = std::find_if(all_.rbegin(), all_.rend(), [&](const auto& known) {
    return differences(known->key, key).empty();
  });
  return found == all_.rend() ? nullptr : *found;
}

std::string CalibrationShelf::why_none(const CalibrationKey& key) const {
  const Calibration* likeliest = nullptr;
  std::vector<std::string> lacks;
  for (const auto& known : all_) {
    std::vector<std::string> other = differences(known->key, key);
    if (likeliest != nullptr && other.size() > lacks.size()) continue;
    likeliest = known.get();
    lacks = std::move(other);
  }
  if (likeliest == nullptr) return std::string("there is no calibration: ") + kRun;
  return fmt::format("{} was measured with another {}: {}", title_of(*likeliest),
                     fmt::join(lacks, ", "), kRun);
}

void CalibrationShelf::put(Calibration calibration) {
  const std::string name = name_of(*calibration.origin);
  keep(calibration);
  std::erase_if(all_, [&](const auto& known) {
    if (!differences(known->key, calibration.key).empty()) return false;
    const std::string other = name_of(*known->origin);
    // One of the same name has been overwritten.
    if (other != name && !calibration.sha256.empty()) {
      if (auto dropped = drop_file(other); !dropped) {
        events_.emit("calibration", Severity::warning, dropped.error().reason);
      }
    }
    return true;
  });
  all_.push_back(std::make_shared<const Calibration>(std::move(calibration)));
  if (all_.size() > kMost) all_.erase(all_.begin());
  drop_oldest();
}

void CalibrationShelf::keep(Calibration& calibration) {
  const std::string name = name_of(*calibration.origin);
  const auto kept = store_.put(kKind, name, calibration_content(calibration));
  calibration.sha256 = kept.value_or("");
  json data{{"t_taken_ns", calibration.t_taken_ns}};
  if (!kept) {
    if (!store_.report().directory) return;
    events_.emit("calibration", Severity::error,
                 fmt::format("{} is in force, and will not survive a restart: {}",
                             title_of(calibration), kept.error().reason),
                 std::move(data));
    return;
  }
  data["sha256"] = *kept;
  events_.emit("calibration", Severity::info,
               fmt::format("{} is kept (sha256 {})", title_of(calibration), *kept),
               std::move(data));
  forget(name);
  kept_.push_back({calibration.t_taken_ns, name});
}

Result<void> CalibrationShelf::drop(const CalibrationKey& key) {
  while (const auto known = find(key)) {
    if (auto dropped = drop_file(name_of(*known->origin)); !dropped) return dropped;
    std::erase(all_, known);
  }
  return {};
}

Result<void> CalibrationShelf::drop_file(const std::string& name) {
  if (auto dropped = store_.drop(kKind, name); !dropped) return dropped;
  forget(name);
  return {};
}

void CalibrationShelf::forget(const std::string& name) {
  std::erase_if(kept_, [&](const Kept& one) { return one.name == name; });
  aside_.erase(name);
}

void CalibrationShelf::drop_oldest() {
  while (kept_.size() > kMost) {
    const auto oldest =
        std::min_element(kept_.begin(), kept_.end(),
                         [](const Kept& a, const Kept& b) { return a.t_taken_ns < b.t_taken_ns; });
    if (!drop_file(std::string(oldest->name))) return;  // the next one tries again
  }
}

}  // namespace ovws
