#include "daemon/reference_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>

#include "daemon/reference_file.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "reference";

}  // namespace

std::string title_of(const Reference& reference) {
  return "the reference of " + utc_text(reference.t_taken_ns);
}

std::vector<Reference> ReferenceArchive::load() {
  return load_those([](const std::string&) { return true; });
}

std::vector<Reference> ReferenceArchive::load_again() {
  std::set<std::string> names;
  for (const auto& [name, slm] : aside_) {
    if (slm == bench_.slm()) names.insert(name);
  }
  if (names.empty()) return {};
  return load_those([&](const std::string& name) { return names.contains(name); });
}

std::vector<Reference> ReferenceArchive::load_those(
    const std::function<bool(const std::string&)>& wanted) {
  std::vector<Reference> usable;
  store_.load(kKind, [&](const StateItem& item) {
    if (!wanted(item.name)) return;
    if (auto reference = use(item)) usable.push_back(std::move(*reference));
  });
  std::sort(usable.begin(), usable.end(),
            [](const Reference& a, const Reference& b) { return a.t_taken_ns < b.t_taken_ns; });
  return usable;
}

std::optional<Reference> ReferenceArchive::use(const StateItem& item) {
  json data{{"path", item.path}, {"sha256", item.sha256}, {"used", false}};
  auto reference = reference_from(item.content);
  if (!reference) {
    const Error& why = reference.error();
    events_.emit(
        "reference", Severity::warning,
        fmt::format("{} is not used, and left as it is: {} {}", item.path, why.field, why.reason),
        std::move(data));
    return std::nullopt;
  }
  forget(item.name);
  kept_.push_back({reference->t_taken_ns, item.name});
  reference->sha256 = item.sha256;
  const std::string obstacle = item.name == identity_of(*reference->origin)
                                   ? bench_.obstacle(*reference)
                                   : "its file's name is not that of its content";
  data["t_taken_ns"] = reference->t_taken_ns;
  data["used"] = obstacle.empty();
  const std::string found =
      fmt::format("{} ({}, sha256 {})", title_of(*reference), item.path, item.sha256);
  if (!obstacle.empty()) {
    const json& origin = *reference->origin;
    if (bench_.has_other_slm_only(origin)) aside_[item.name] = origin["slm"];
    events_.emit("reference", Severity::warning, found + " is not used: " + obstacle,
                 std::move(data));
    return std::nullopt;
  }
  events_.emit("reference", Severity::info, found + " is found again", std::move(data));
  return std::move(*reference);
}

void ReferenceArchive::keep(Reference& reference) {
  const std::string name = identity_of(*reference.origin);
  const auto kept = store_.put(kKind, name, reference_content(reference));
  reference.sha256 = kept.value_or("");
  json data{{"t_taken_ns", reference.t_taken_ns}};
  if (!kept) {
    if (store_.report().directory) {
      events_.emit("reference", Severity::error,
                   fmt::format("{} is in force, and will not survive a restart: {}",
                               title_of(reference), kept.error().reason),
                   std::move(data));
    }
    return;
  }
  data["sha256"] = *kept;
  events_.emit("reference", Severity::info,
               fmt::format("{} is kept (sha256 {})", title_of(reference), *kept), std::move(data));
  forget(name);
  kept_.push_back({reference.t_taken_ns, name});
  drop_oldest();
}

Result<void> ReferenceArchive::drop(const Reference& reference) {
  const std::string name = identity_of(*reference.origin);
  if (auto dropped = store_.drop(kKind, name); !dropped) return dropped;
  forget(name);
  return {};
}

void ReferenceArchive::forget(const std::string& name) {
  std::erase_if(kept_, [&](const Kept& one) { return one.name == name; });
  aside_.erase(name);
}

void ReferenceArchive::drop_oldest() {
  while (kept_.size() > kMostKept) {
    const auto oldest =
        std::min_element(kept_.begin(), kept_.end(),
                         [](const Kept& a, const Kept& b) { return a.t_taken_ns < b.t_taken_ns; });
    if (!store_.drop(kKind, oldest->name)) return;  // the next one tries again
    kept_.erase(oldest);
  }
}

}  // namespace ovws
