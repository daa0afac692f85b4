#include "daemon/ovwsd/sensor/calibration_shelf.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/sensor/calibration_file.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/time.hpp"

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

std::vector<std::string> names_of(const std::vector<std::shared_ptr<const Calibration>>& all) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(name_of(*one->origin));
  return names;
}

void drop_quietly(DaemonStore& store, Events& events, const std::vector<std::string>& names) {
  store.drop_all(kKind, names, [&events](const Result<void>& dropped) {
    if (!dropped) events.emit("calibration", Severity::warning, dropped.error().reason);
  });
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
  store_.load(kKind, [&](const StateItem& item) { read(item); });
  sort_by_age();
}

void CalibrationShelf::load_again() {
  std::map<std::string, Found> aside;
  aside.swap(aside_);
  for (auto& [name, found] : aside) {
    if ((*found.calibration.origin)["slm"] == bench_.slm()) {
      use(std::move(found));
    } else {
      aside_.emplace(name, std::move(found));
    }
  }
  sort_by_age();
}

void CalibrationShelf::sort_by_age() {
  std::sort(all_.begin(), all_.end(),
            [](const auto& a, const auto& b) { return a->t_taken_ns < b->t_taken_ns; });
}

void CalibrationShelf::read(const StateItem& item) {
  auto calibration = calibration_from(item.content, bench_.config());
  if (!calibration) {
    const Error& why = calibration.error();
    events_.emit(
        "calibration", Severity::warning,
        fmt::format("{} is not used, and left as it is: {} {}", item.path, why.field, why.reason),
        {{"path", item.path}, {"sha256", item.sha256}, {"used", false}});
    return;
  }
  forget(item.name);
  kept_.push_back({calibration->t_taken_ns, item.name});
  calibration->sha256 = item.sha256;
  use({item.name, item.path, std::move(*calibration)});
}

void CalibrationShelf::use(Found found) {
  Calibration& calibration = found.calibration;
  std::string obstacle = bench_.obstacle(*calibration.origin, calibration.key.sensor,
                                         std::size_t(calibration.matrix.spots()));
  if (obstacle.empty()) {
    auto comparison = compared(calibration, bench_.config().slm.geometry);
    if (comparison) calibration.comparison = std::move(*comparison);
    if (!comparison) obstacle = comparison.error().reason;
  }
  json data{{"path", found.path},
            {"sha256", calibration.sha256},
            {"used", obstacle.empty()},
            {"t_taken_ns", calibration.t_taken_ns}};
  const std::string what =
      fmt::format("{} ({}, sha256 {})", title_of(calibration), found.path, calibration.sha256);
  if (!obstacle.empty()) {
    events_.emit("calibration", Severity::warning, what + " is not used: " + obstacle,
                 std::move(data));
    if (!bench_.has_other_slm_only(*calibration.origin)) return;
    const std::string name = found.name;
    aside_.insert_or_assign(name, std::move(found));
    return;
  }
  events_.emit("calibration", Severity::info, what + " is found again", std::move(data));
  all_.push_back(std::make_shared<const Calibration>(std::move(calibration)));
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

void CalibrationShelf::put(Calibration calibration,
                           std::function<void(const std::string& sha256)> told) {
  const std::string name = name_of(*calibration.origin);
  const auto replaced = take(calibration.key);
  std::vector<std::string> others;  // one of the same name is overwritten
  for (const std::string& other : names_of(replaced)) {
    if (other != name) others.push_back(other);
  }
  for (const std::string& other : others) forget(other);
  const auto then = [&store = store_, &events = events_, others,
                     told = std::move(told)](const std::string& sha256) {
    if (!sha256.empty()) drop_quietly(store, events, others);
    if (told) told(sha256);
  };
  forget(name);
  kept_.push_back({calibration.t_taken_ns, name});
  const auto reporting =
      store_.reporting("calibration", title_of(calibration), calibration.t_taken_ns, then);
  const json content = calibration_content(calibration);
  all_.push_back(std::make_shared<const Calibration>(std::move(calibration)));
  if (all_.size() > kMost) all_.erase(all_.begin());
  store_.put(kKind, name, content, DaemonStore::Older::set_aside, reporting);
  drop_oldest();
}

std::shared_ptr<const Calibration> CalibrationShelf::know_file(std::int64_t t_taken_ns,
                                                               const std::string& sha256) {
  for (auto& known : all_) {
    if (known->t_taken_ns != t_taken_ns) continue;
    auto with_file = std::make_shared<Calibration>(*known);
    with_file->sha256 = sha256;
    known = std::move(with_file);
    return known;
  }
  return nullptr;
}

std::vector<std::shared_ptr<const Calibration>> CalibrationShelf::take(const CalibrationKey& key) {
  std::vector<std::shared_ptr<const Calibration>> taken;
  std::erase_if(all_, [&](const auto& known) {
    if (!differences(known->key, key).empty()) return false;
    taken.push_back(known);
    return true;
  });
  return taken;
}

void CalibrationShelf::put_back(const std::vector<std::shared_ptr<const Calibration>>& taken) {
  all_.insert(all_.end(), taken.begin(), taken.end());
  sort_by_age();
}

void CalibrationShelf::drop_files(const std::vector<std::shared_ptr<const Calibration>>& taken,
                                  DaemonStore::Dropped told) {
  const std::vector<std::string> names = names_of(taken);
  for (const std::string& name : names) forget(name);
  store_.drop_all(kKind, names, std::move(told));
}

void CalibrationShelf::forget(const std::string& name) {
  std::erase_if(kept_, [&](const Kept& one) { return one.name == name; });
  aside_.erase(name);
}

void CalibrationShelf::drop_oldest() {
  while (kept_.size() > kMost) {
    // But the newest: the time of day may have been set back.
    const auto oldest =
        std::min_element(kept_.begin(), std::prev(kept_.end()),
                         [](const Kept& a, const Kept& b) { return a.t_taken_ns < b.t_taken_ns; });
    const std::string name = oldest->name;
    drop_quietly(store_, events_, {name});
    forget(name);
  }
}

}  // namespace ovws
