/// Measured items of one kind (references, calibrations, LUT, flatness) in the state store, loaded
/// again after a restart.
#pragma once

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// "the reference of 2026-01-31T12:00:00.000Z"
template <class Kind>
std::string title_of(const typename Kind::Item& item) {
  return fmt::format("the {} of {}", Kind::kTitle, utc_text(item.t_taken_ns));
}

/// `Kind` describes its items, which have `t_taken_ns`, and `sha256`, the checksum of their file:
///
///     using Item = …;
///     static constexpr const char *kKind = …, *kEvent = …;   // of the files, of the events
///     static constexpr const char *kTitle = …, *kMethod = …; // what it is, and what measures it
///     std::string name(const Item&) const;                   // of its file, [a-z0-9_-]
///     nlohmann::json content(const Item&) const;             // of its file
///     Result<Item> read(const nlohmann::json&) const;        // errors: what is inconsistent
///     // Why this bench cannot use the item; empty: it can. May complete the item.
///     std::string obstacle(Item&) const;
///     // Only of kinds that depend on LUT and flatness; the items have their `origin`.
///     const ReferenceBench* bench;
///
/// Call the methods in one thread at a time. Only `load` blocks on the disk.
template <class Kind>
class Kept {
 public:
  using Item = typename Kind::Item;
  using Items = std::vector<std::shared_ptr<const Item>>;  ///< oldest first
  using Stored = std::function<void(const std::string& sha256)>;
  /// Limit of stored items of a kind, whatever sensor and bench they belong to; the oldest is
  /// deleted first.
  static constexpr std::size_t kMax = 16;

  Kept(Kind kind, DaemonStore& store, Events& events)
      : kind_(std::move(kind)), store_(store), events_(events) {}

  /// Loads all usable items. An event reports each file with its checksum and measurement time, and
  /// why an item is not used. Unused files stay on the disk.
  Items load() {
    Items usable;
    store_.load(Kind::kKind, [&](const StateItem& item) {
      if (auto read = this->read(item)) usable.push_back(std::move(read));
    });
    return by_age(std::move(usable));
  }

  /// Returns items that were unusable only with the previous LUT or flatness, and are usable now.
  /// Each item is returned once.
  Items load_again() {
    Items usable;
    for (auto& [name, found] : std::exchange(waiting_for_slm_, {})) {
      if (!fits_slm(found.item)) {
        waiting_for_slm_.emplace(name, std::move(found));
      } else if (auto item = use(std::move(found))) {
        usable.push_back(std::move(item));
      }
    }
    return by_age(std::move(usable));
  }

  /// Stores an item, and then deletes the items `replaced`. Calls `done` in the disk thread with
  /// the item's checksum. The checksum is empty if the write failed, which an event reports. Calls
  /// `done` again if a later attempt succeeds.
  void keep(const Item& item, const std::vector<std::string>& replaced = {},
            Stored done = nullptr) {
    const std::string name = kind_.name(item);
    for (const std::string& other : replaced) forget(other);
    forget(name);
    files_.push_back({item.t_taken_ns, name});
    const auto then = [&store = store_, &events = events_, replaced,
                       done = std::move(done)](const std::string& sha256) {
      if (!sha256.empty()) drop_quietly(store, events, replaced);
      if (done) done(sha256);
    };
    store_.put(Kind::kKind, name, kind_.content(item), DaemonStore::Older::set_aside,
               store_.reporting(Kind::kEvent, title_of<Kind>(item), item.t_taken_ns, then));
    drop_oldest();
  }

  /// Deletes the items with these names. Calls `done` in the disk thread; an error means that some
  /// files are still on the disk.
  void drop(const std::vector<std::string>& names, DaemonStore::Dropped done) {
    for (const std::string& name : names) forget(name);
    store_.drop_all(Kind::kKind, names, std::move(done));
  }

  const Kind& kind() const { return kind_; }

 private:
  struct File {
    std::int64_t t_taken_ns = 0;
    std::string name;
  };
  struct Found {
    std::string name, path;
    Item item;
  };

  static constexpr bool kOfSlm = requires(const Kind& kind) { kind.bench; };

  /// True if only a different LUT or flatness prevents the use of the item.
  bool needs_other_slm(const Item& item) const {
    if constexpr (kOfSlm) return kind_.bench->has_other_slm_only(*item.origin);
    return false;
  }
  /// True if the item was measured with the active LUT and flatness.
  bool fits_slm(const Item& item) const {
    if constexpr (kOfSlm) return (*item.origin)["slm"] == kind_.bench->slm();
    return false;
  }

  static Items by_age(Items items) {
    std::sort(items.begin(), items.end(),
              [](const auto& a, const auto& b) { return a->t_taken_ns < b->t_taken_ns; });
    return items;
  }

  static void drop_quietly(DaemonStore& store, Events& events,
                           const std::vector<std::string>& names) {
    store.drop_all(Kind::kKind, names, [&events](const Result<void>& dropped) {
      if (!dropped) events.emit(Kind::kEvent, Severity::warning, dropped.error().reason);
    });
  }

  std::shared_ptr<const Item> read(const StateItem& file) {
    auto item = kind_.read(file.content);
    if (!item) {
      const Error& why = item.error();
      events_.emit(Kind::kEvent, Severity::warning,
                   fmt::format("{} is not used, and left as it is: {}{}{}; restore it from a "
                               "backup, or delete it and measure again ({})",
                               file.path, why.field, why.field.empty() ? "" : " ", why.reason,
                               Kind::kMethod),
                   {{"path", file.path}, {"sha256", file.sha256}, {"used", false}});
      return nullptr;
    }
    forget(file.name);
    files_.push_back({item->t_taken_ns, file.name});
    item->sha256 = file.sha256;
    return use({file.name, file.path, std::move(*item)});
  }

  /// Returns the item, or null if it cannot be used now. Remembers an item that another LUT or
  /// flatness would make usable.
  std::shared_ptr<const Item> use(Found found) {
    const std::string remedy = fmt::format("; undo what has changed, or run {}", Kind::kMethod);
    Item& item = found.item;
    const std::string obstacle = found.name == kind_.name(item)
                                     ? kind_.obstacle(item)
                                     : "its file name does not match its content";
    events_.emit(Kind::kEvent, obstacle.empty() ? Severity::info : Severity::warning,
                 fmt::format("{} ({}, sha256 {}) {}", title_of<Kind>(item), found.path, item.sha256,
                             obstacle.empty() ? "is loaded" : "is not used: " + obstacle + remedy),
                 {{"path", found.path},
                  {"sha256", item.sha256},
                  {"used", obstacle.empty()},
                  {"t_taken_ns", item.t_taken_ns}});
    if (obstacle.empty()) return std::make_shared<const Item>(std::move(item));
    if (needs_other_slm(item)) {
      const std::string name = found.name;
      waiting_for_slm_.insert_or_assign(name, std::move(found));
    }
    return nullptr;
  }

  void forget(const std::string& name) {
    std::erase_if(files_, [&](const File& one) { return one.name == name; });
    waiting_for_slm_.erase(name);
  }

  void drop_oldest() {
    while (files_.size() > kMax) {
      // The newest file stays even if the clock was set back.
      const auto oldest = std::min_element(
          files_.begin(), std::prev(files_.end()),
          [](const File& a, const File& b) { return a.t_taken_ns < b.t_taken_ns; });
      const std::string name = oldest->name;
      drop_quietly(store_, events_, {name});
      forget(name);
    }
  }

  Kind kind_;
  DaemonStore& store_;
  Events& events_;
  std::vector<File> files_;                       ///< undamaged files, used or not
  std::map<std::string, Found> waiting_for_slm_;  ///< by name
};

}  // namespace ovws
