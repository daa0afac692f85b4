#include "daemon/ovwsd/sensor/named_references.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <utility>

#include "config/tables.hpp"
#include "daemon/ovwsd/sensor/reference_file.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kReferenceKind = "saved-reference";

tl::unexpected<Error> no_such_reference(const std::string& name) {
  return fail(Errc::invalid, "name",
              "there is no saved reference \"" + name + "\"; reference.list lists them");
}

std::shared_ptr<const Reference> without_image(Reference reference) {
  reference.picture.reset();
  return std::make_shared<const Reference>(std::move(reference));
}

json json_of_key(const ReferenceKey& key) {
  return {{"sensor", to_json(key.sensor)},
          {"tracking", to_json(ConfiguredTracking(key.tracking))},
          {"camera.roi", to_json(key.roi)}};
}

}  // namespace

void NamedReferences::load() {
  store_.load(kReferenceKind, [this](const StateItem& item) {
    auto reference = reference_from(item.content);
    if (reference) {
      all_[item.name] = without_image(std::move(*reference));
    } else {
      events_.emit("reference", Severity::warning,
                   fmt::format("{} is not used, and left as it is: {} {}", item.path,
                               reference.error().field, reference.error().reason),
                   {{"path", item.path}, {"used", false}});
    }
  });
}

NamedReferences::All NamedReferences::all() const {
  const std::lock_guard lock(mutex_);
  return all_;
}

Result<void> NamedReferences::add(const std::string& name, const Reference& reference) {
  const std::lock_guard lock(mutex_);
  if (all_.contains(name)) {
    return fail(Errc::refused, "name",
                "a reference \"" + name +
                    "\" is saved already: choose another name, or delete it with reference.delete");
  }
  if (all_.size() >= kMax) {
    return fail(
        Errc::refused, "name",
        fmt::format("{} references are saved already: delete some with reference.delete", kMax));
  }
  all_[name] = without_image(reference);
  return {};
}

void NamedReferences::forget(const std::string& name) {
  const std::lock_guard lock(mutex_);
  all_.erase(name);
}

void NamedReferences::save(const std::string& name, std::shared_ptr<const Reference> reference,
                           Done done) {
  const auto asked = store_.request([this, name, reference = std::move(reference), done] {
    if (auto added = add(name, *reference); !added) return done(added);
    store_.put(kReferenceKind, name, reference_content(*reference), DaemonStore::Older::stays,
               [this, name, done](const Result<std::string>& kept) {
                 if (kept) return done({});
                 forget(name);
                 store_.drop(kReferenceKind, name, [](const Result<void>&) {});  // no later attempt
                 done(fail(kept.error()));
               });
  });
  if (!asked) done(asked);
}

void NamedReferences::find(const std::string& name, std::function<void(Result<Reference>)> done) {
  const auto asked = store_.request([this, name, done] {
    const auto item = store_.find(kReferenceKind, name);
    if (!item) return done(no_such_reference(name));
    done(reference_from(item->content));
  });
  if (!asked) done(fail(asked.error()));
}

void NamedReferences::remove(const std::string& name, Done done) {
  if (!all().contains(name)) return done(no_such_reference(name));
  store_.drop(kReferenceKind, name,
              [this, name, done = std::move(done)](const Result<void>& dropped) {
                if (dropped) forget(name);
                done(dropped);
              });
}

std::string misfit(const Reference& reference, const SensorEdit& now) {
  const SensorState& state = now.state;
  if (auto found = check_array_found(state); !found) return found.error().reason;
  const json then = json_of_key(reference.key), wanted = json_of_key(reference_key(state));
  for (const auto& [part, value] : then.items()) {
    auto differs = first_difference(part, value, wanted[part]);
    if (!differs.empty()) return differs;
  }
  auto optics = first_difference("optics", reference.origin->value("optics", json()),
                                 to_json(now.bench.config.optics));
  if (!optics.empty()) return optics;
  return unused_reason(reference, state, now.knowledge, now.bench.optics);
}

}  // namespace ovws
