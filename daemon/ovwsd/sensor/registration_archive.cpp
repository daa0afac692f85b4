#include "daemon/ovwsd/sensor/registration_archive.hpp"

#include <spdlog/fmt/fmt.h>

#include <vector>

#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "proto/limits.hpp"
#include "proto/reader.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "registration";
constexpr const char* kName = "camera";
constexpr double kMostPx = 1e5;     ///< of a base spot: far beyond any sensor
constexpr double kMostCpp = 0.5;    ///< of a grating
constexpr double kMostScale = 1e6;  ///< of px_per_cycle

std::string title_of(const Registration& registration) {
  return "the registration of " + utc_text(registration.t_taken_ns);
}

json slm_json(const SlmGeometry& slm) {
  return {{"width", slm.width_px}, {"height", slm.height_px}, {"pitch_um", slm.pitch_um}};
}

/// The keys of registration.get, and the grating that base_px is of.
Result<Registration> registration_from(const json& content) {
  Registration out;
  std::vector<double> base, base_error, map, error, grating;
  ObjectReader r(content, "registration");
  const auto list = [&r](const char* key, std::vector<double>& to, std::size_t size, double most) {
    r.require(key);
    r.numbers(key, to, size, size, -most, most);
  };
  list("base_px", base, 2, kMostPx);
  list("base_standard_error_px", base_error, 2, kMostPx);
  list("base_grating_cpp", grating, 2, kMostCpp);
  list("px_per_cycle", map, 4, kMostScale);
  list("px_per_cycle_standard_error", error, 4, kMostScale);
  r.require("residual_px");
  r.number("residual_px", out.residual_px, 0.0, kMostPx);
  r.require("sights");
  r.integer("sights", out.sights, 0, 1 << 20);
  for (const char* known : {"registered", "scale_px_per_cycle", "rotation_deg", "mirrored"}) {
    r.raw(known);
  }
  const json* const taken = r.raw("t_taken_ns");
  if (taken != nullptr && taken->is_number_integer()) out.t_taken_ns = taken->get<std::int64_t>();
  if (auto done = r.finish(); !done) return fail(done.error());
  out.base_px = {base[0], base[1]};
  out.base_standard_error_px = {base_error[0], base_error[1]};
  out.base_cpp = {grating[0], grating[1]};
  out.px_per_cycle = {map[0], map[1], map[2], map[3]};
  out.standard_error = {error[0], error[1], error[2], error[3]};
  if (out.px_per_cycle.scale() < limits::kLeastPxPerCycle) {
    return fail(Errc::invalid, "registration.px_per_cycle", "is not a map of slopes");
  }
  return out;
}

}  // namespace

Result<Registration> RegistrationArchive::use(const json& content) {
  if (!content.is_object() || !content.contains("registration") || !content.contains("slm")) {
    return fail(Errc::invalid, "", "it is not that of a registration");
  }
  if (content["slm"] != slm_json(slm_)) {
    return fail(
        Errc::invalid, "slm",
        "it is of another SLM: " + content["slm"].dump() + ", not " + slm_json(slm_).dump());
  }
  return registration_from(content["registration"]);
}

std::optional<Registration> RegistrationArchive::load() {
  std::optional<Registration> found;
  store_.load(kKind, [&](const StateItem& item) {
    json data{{"path", item.path}, {"sha256", item.sha256}, {"used", false}};
    const bool named = item.name == kName;
    const auto kept = use(item.content);
    if (!kept || !named) {
      const std::string why = named ? kept.error().reason : "its file's name is not the daemon's";
      return events_.emit("registration", Severity::warning,
                          fmt::format("{} is not used, and left as it is: {}", item.path, why),
                          std::move(data));
    }
    camera_ = item.content.value("camera", json());
    data["used"] = true;
    data["t_taken_ns"] = kept->t_taken_ns;
    events_.emit(
        "registration", Severity::info,
        fmt::format("{} ({}, sha256 {}) is found again", title_of(*kept), item.path, item.sha256),
        std::move(data));
    found = *kept;
  });
  return found;
}

void RegistrationArchive::keep(const Registration& registration,
                               const std::optional<CameraInfo>& camera,
                               std::function<void(const std::string& sha256)> told) {
  camera_ = camera_json(camera);
  json numbers = to_json(KnownRegistration{registration});
  numbers["base_grating_cpp"] = {registration.base_cpp.x, registration.base_cpp.y};
  store_.put(
      kKind, kName, {{"registration", numbers}, {"slm", slm_json(slm_)}, {"camera", camera_}},
      DaemonStore::Older::set_aside,
      store_.reporting(kKind, title_of(registration), registration.t_taken_ns, std::move(told)));
}

void RegistrationArchive::drop(DaemonStore::Dropped told) {
  store_.drop(kKind, kName, std::move(told));
}

bool RegistrationArchive::is_of_another(const std::optional<CameraInfo>& camera) const {
  return camera && !camera_.is_null() && camera_ != camera_json(camera);
}

}  // namespace ovws
