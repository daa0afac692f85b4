/// Items that a person has named: saved references, prepared lattices.
#pragma once

#include <spdlog/fmt/fmt.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "core/base/result.hpp"
#include "daemon/ovwsd/library/library.hpp"
#include "daemon/ovwsd/library/reference.hpp"

namespace ovws {

/// Named items of one kind, one file each. `Of` describes them:
///
///     using Item = …;
///     static constexpr const ItemKind& kKind = …;
///     static constexpr std::size_t kMost = …;             // of `add` only
///     static constexpr const char* kRemove = …;           // the method; of `add` only
///     static constexpr const char* kMissing = …;          // what to say of a name without an item
///     static std::int64_t time(const Item&);              // UTC, ns
///     static nlohmann::json encode(const Item&);
///     static Result<Item> decode(const nlohmann::json&);
///     static Item in_memory(Item);                        // the part of it that stays in memory
///
/// Thread-safe; callbacks are called in the disk thread, or in the caller's if the disk takes no
/// request.
template <class Of>
class NamedItems {
 public:
  using Item = typename Of::Item;
  using ItemPtr = std::shared_ptr<const Item>;
  using All = std::map<std::string, ItemPtr>;  ///< by name, each as in_memory
  using Done = std::function<void(Result<void>)>;

  explicit NamedItems(Library& library) : library_(library) {}

  /// Reads all files; blocks on the disk. An event reports each that cannot be used.
  void load() {
    library_.load(Of::kKind, [this](const StateItem& file) -> Result<void> {
      auto item = Of::decode(file.content);
      if (!item) return fail(item.error());
      set(file.name, std::move(*item));
      return {};
    });
  }
  All all() const {
    const std::lock_guard lock(mutex_);
    return all_;
  }
  /// The item in memory. Errc::invalid, field "name": there is none of this name.
  Result<ItemPtr> find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = all_.find(name);
    if (found == all_.end()) return missing(name);
    return found->second;
  }
  /// Reads the whole item. Errors: as find; its file is damaged.
  void read(const std::string& name, std::function<void(Result<Item>)> done) const {
    const auto asked = library_.request([this, name, done] {
      if (auto known = find(name); !known) return done(fail(known.error()));
      const auto file = library_.read(Of::kKind, name);
      done(file ? Of::decode(file->content) : fail(file.error()));
    });
    if (!asked) done(fail(asked.error()));
  }
  /// Writes a new item, which counts once it is on the disk. Errc::refused, field "name": the name
  /// is taken, if only by a file that could not be loaded, or there are kMost already.
  /// Errc::unavailable: there is no state folder, or the disk does not take it.
  void add(const std::string& name, ItemPtr item, Done done) {
    const auto asked = library_.request([this, name, item = std::move(item), done] {
      const auto added = set_new(name, *item);
      if (!added) return done(fail(added.error()));
      const auto end = [this, name, added, done](const Result<void>& stored) {
        if (!stored) forget(name, *added);
        done(stored);
      };
      if (auto is_new = library_.check_new(Of::kKind, name); !is_new) return end(is_new);
      library_.put(
          {&Of::kKind, name, Of::time(*item), Of::encode(*item), "", {}, true},
          [end](const Result<std::string>& sum) { end(sum ? Result<void>{} : fail(sum.error())); });
    });
    if (!asked) done(asked);
  }
  /// Adds or replaces an item. An event reports its file, or why it cannot be written; `stored`
  /// see Library::put.
  void keep(const std::string& name, const Item& item, Library::Stored stored) {
    set(name, item);
    library_.put({&Of::kKind, name, Of::time(item), Of::encode(item),
                  fmt::format("the {} {}", Of::kKind.title, name)},
                 std::move(stored));
  }
  /// Deletes an item. Errors: as find; its file cannot be removed.
  void remove(const std::string& name, Done done) {
    const auto known = find(name);
    if (!known) return done(fail(known.error()));
    library_.remove(Of::kKind, {name},
                    [this, name, known, done = std::move(done)](const Result<void>& removed) {
                      if (removed) forget(name, *known);
                      done(removed);
                    });
  }

 private:
  static tl::unexpected<Error> missing(const std::string& name) {
    return fail(Errc::invalid, "name",
                fmt::format("there is no {} \"{}\"; {}", Of::kKind.title, name, Of::kMissing));
  }
  void set(const std::string& name, Item item) {
    auto shown = std::make_shared<const Item>(Of::in_memory(std::move(item)));
    const std::lock_guard lock(mutex_);
    all_[name] = std::move(shown);
  }
  Result<ItemPtr> set_new(const std::string& name, const Item& item) {
    const std::lock_guard lock(mutex_);
    if (all_.contains(name)) {
      return fail(Errc::refused, "name",
                  fmt::format("\"{}\" is saved already: choose another name, or delete it with {}",
                              name, Of::kRemove));
    }
    if (all_.size() >= Of::kMost) {
      return fail(Errc::refused, "name",
                  fmt::format("there are {} {}s already: delete some with {}", Of::kMost,
                              Of::kKind.title, Of::kRemove));
    }
    return all_[name] = std::make_shared<const Item>(Of::in_memory(item));
  }
  /// Forgets the item, but not another one that has its name now.
  void forget(const std::string& name, const ItemPtr& item) {
    const std::lock_guard lock(mutex_);
    const auto found = all_.find(name);
    if (found != all_.end() && found->second == item) all_.erase(found);
  }

  Library& library_;
  mutable std::mutex mutex_;
  All all_;
};

/// References that reference.save has stored; in memory without their mean images.
struct ReferenceItem {
  using Item = Reference;
  static constexpr const ItemKind& kKind = kSavedReferenceItems;
  static constexpr std::size_t kMost = 32;
  static constexpr const char* kRemove = "reference.delete";
  static constexpr const char* kMissing = "reference.list lists them";
  static std::int64_t time(const Reference& reference) { return reference.t_taken_ns; }
  static constexpr auto encode = reference_content;
  static constexpr auto decode = reference_from;
  static Reference in_memory(Reference reference) {
    reference.picture.reset();
    return reference;
  }
};
class NamedReferences : public NamedItems<ReferenceItem> {
 public:
  using NamedItems::NamedItems;
};

}  // namespace ovws
