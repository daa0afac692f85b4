#include "daemon/ovwsd/sensor/reference_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>

#include "daemon/ovwsd/sensor/reference_file.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "reference";

void sort_by_age(std::vector<Reference>& references) {
  std::sort(references.begin(), references.end(),
            [](const Reference& a, const Reference& b) { return a.t_taken_ns < b.t_taken_ns; });
}

void drop_quietly(DaemonStore& store, Events& events, const std::vector<std::string>& names) {
  store.drop_all(kKind, names, [&events](const Result<void>& dropped) {
    if (!dropped) events.emit("reference", Severity::warning, dropped.error().reason);
  });
}

}  // namespace

std::string title_of(const Reference& reference) {
  return "the reference of " + utc_text(reference.t_taken_ns);
}

std::vector<Reference> ReferenceArchive::load() {
  std::vector<Reference> usable;
  store_.load(kKind, [&](const StateItem& item) {
    if (auto reference = read(item)) usable.push_back(std::move(*reference));
  });
  sort_by_age(usable);
  return usable;
}

std::vector<Reference> ReferenceArchive::load_again() {
  std::vector<Reference> usable;
  std::map<std::string, Found> aside;
  aside.swap(aside_);
  for (auto& [name, found] : aside) {
    if ((*found.reference.origin)["slm"] != bench_.slm()) {
      aside_.emplace(name, std::move(found));
    } else if (auto reference = use(std::move(found))) {
      usable.push_back(std::move(*reference));
    }
  }
  sort_by_age(usable);
  return usable;
}

std::optional<Reference> ReferenceArchive::read(const StateItem& item) {
  auto reference = reference_from(item.content);
  if (!reference) {
    const Error& why = reference.error();
    events_.emit(
        "reference", Severity::warning,
        fmt::format("{} is not used, and left as it is: {} {}", item.path, why.field, why.reason),
        {{"path", item.path}, {"sha256", item.sha256}, {"used", false}});
    return std::nullopt;
  }
  forget(item.name);
  kept_.push_back({reference->t_taken_ns, item.name});
  reference->sha256 = item.sha256;
  return use({item.name, item.path, std::move(*reference)});
}

std::optional<Reference> ReferenceArchive::use(Found found) {
  const Reference& reference = found.reference;
  const std::string obstacle = found.name == identity_of(*reference.origin)
                                   ? bench_.obstacle(reference)
                                   : "its file's name is not that of its content";
  json data{{"path", found.path},
            {"sha256", reference.sha256},
            {"used", obstacle.empty()},
            {"t_taken_ns", reference.t_taken_ns}};
  const std::string what =
      fmt::format("{} ({}, sha256 {})", title_of(reference), found.path, reference.sha256);
  if (!obstacle.empty()) {
    events_.emit("reference", Severity::warning, what + " is not used: " + obstacle,
                 std::move(data));
    if (!bench_.has_other_slm_only(*reference.origin)) return std::nullopt;
    const std::string name = found.name;
    aside_.insert_or_assign(name, std::move(found));
    return std::nullopt;
  }
  events_.emit("reference", Severity::info, what + " is found again", std::move(data));
  return std::move(found.reference);
}

void ReferenceArchive::keep(const Reference& reference, const std::vector<std::string>& replaced,
                            std::function<void(const std::string& sha256)> told) {
  const std::string name = identity_of(*reference.origin);
  for (const std::string& other : replaced) forget(other);
  const auto then = [&store = store_, &events = events_, replaced,
                     told = std::move(told)](const std::string& sha256) {
    if (!sha256.empty()) drop_quietly(store, events, replaced);
    if (told) told(sha256);
  };
  forget(name);
  kept_.push_back({reference.t_taken_ns, name});
  store_.put(kKind, name, reference_content(reference), DaemonStore::Older::set_aside,
             store_.reporting("reference", title_of(reference), reference.t_taken_ns, then));
  drop_oldest();
}

void ReferenceArchive::drop(const std::vector<std::string>& names, DaemonStore::Dropped told) {
  for (const std::string& name : names) forget(name);
  store_.drop_all(kKind, names, std::move(told));
}

void ReferenceArchive::forget(const std::string& name) {
  std::erase_if(kept_, [&](const Kept& one) { return one.name == name; });
  aside_.erase(name);
}

void ReferenceArchive::drop_oldest() {
  while (kept_.size() > kMostKept) {
    // But the newest: the time of day may have been set back.
    const auto oldest =
        std::min_element(kept_.begin(), std::prev(kept_.end()),
                         [](const Kept& a, const Kept& b) { return a.t_taken_ns < b.t_taken_ns; });
    drop_quietly(store_, events_, {oldest->name});
    aside_.erase(oldest->name);
    kept_.erase(oldest);
  }
}

}  // namespace ovws
