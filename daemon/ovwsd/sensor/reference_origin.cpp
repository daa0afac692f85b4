#include "daemon/ovwsd/sensor/reference_origin.hpp"

#include "config/tables.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
#include "proto/limits.hpp"
#include "proto/reader.hpp"
#include "proto/requests.hpp"

namespace ovws {
namespace {

using nlohmann::json;

std::optional<OriginRegistration> of_origin(const std::optional<Registration>& registration) {
  if (!registration) return std::nullopt;
  return OriginRegistration{registration->t_taken_ns, registration->base_px,
                            registration->px_per_cycle};
}

Result<std::optional<Registration>> origin_registration_from(const json& content) {
  if (content.is_null()) return std::nullopt;
  std::vector<double> base, map;
  ObjectReader r(content, "registration");
  for (const char* key : {"t_taken_ns", "base_px", "px_per_cycle"}) r.require(key);
  const json* const t_taken_ns = r.raw("t_taken_ns");
  r.numbers("base_px", base, 2, 2, -1e6, 1e6);
  r.numbers("px_per_cycle", map, 4, 4, limits::kPxPerCycle.min, limits::kPxPerCycle.max);
  if (auto read = r.finish(); !read) return fail(read.error());
  Registration registration;
  registration.base_px = {base[0], base[1]};
  registration.px_per_cycle = {map[0], map[1], map[2], map[3]};
  const bool mappable = registration.px_per_cycle.scale() >= limits::kMinPxPerCycle;
  if (!t_taken_ns->is_number_integer() || !mappable) {
    return fail(Errc::invalid, "registration", "has no valid t_taken_ns or px_per_cycle");
  }
  registration.t_taken_ns = t_taken_ns->get<std::int64_t>();
  return registration;
}

/// Replaces invalid UTF-8: a camera may report any bytes, but JSON files hold UTF-8 only.
std::string as_utf8(const std::string& text) {
  return json_of(json_text(json(text)));
}

std::string hash_of(const Image<std::uint8_t>& grey) {
  return sha256_of(std::span(grey.pixels));
}

/// The value as text; long ones, such as the places of lenslets, only by their beginning.
std::string brief(const json& value) {
  constexpr std::size_t kMost = 60;
  std::string text = json_text(value);
  if (text.size() > kMost) text.replace(kMost, std::string::npos, " ...");
  return text;
}

}  // namespace

std::string first_difference(const std::string& path, const json& then, const json& now) {
  if (!then.is_object() || !now.is_object()) {
    if (then == now) return "";
    const std::string before = brief(then), after = brief(now);
    if (before == after) return path + " was other than it is now";
    return path + " was " + before + ", and is " + after;
  }
  json keys = then;
  keys.update(now);
  for (const auto& [key, value] : keys.items()) {
    const json null;
    auto found = first_difference(path + "." + key, then.contains(key) ? then[key] : null,
                                  now.contains(key) ? now[key] : null);
    if (!found.empty()) return found;
  }
  return {};
}

std::optional<CameraName> camera_name(const std::optional<CameraInfo>& camera) {
  if (!camera) return std::nullopt;
  return CameraName{as_utf8(camera->vendor), as_utf8(camera->model), as_utf8(camera->serial)};
}

json camera_json(const std::optional<CameraInfo>& camera) {
  return to_json(camera_name(camera));
}

ReferenceBench::ReferenceBench(const Config& config, HologramConfig hologram)
    : config_(config), hologram_(std::move(hologram)) {
  bench_ = {{"optics", to_json(config.optics)},
            {"slm", slm_identity(hologram_, config.slm.lut.has_value())}};
}

void ReferenceBench::use_slm(const ActiveSlm& slm) {
  hologram_ = slm.hologram;
  bench_["slm"] = slm.identity;
}

json ReferenceBench::origin(const OriginInputs& inputs) const {
  Origin origin;
  origin.program = OVWS_VERSION;
  origin.camera = camera_name(inputs.camera);
  if (inputs.settings) origin.settings = OriginSettings{*inputs.settings};
  origin.registration = of_origin(inputs.registration);
  origin.roi = inputs.key.roi;
  origin.sensor = inputs.key.sensor;
  origin.tracking.json = to_json(ConfiguredTracking(inputs.key.tracking));
  origin.optics.json = bench_["optics"];
  origin.slm.json = bench_["slm"];
  origin.aberration = inputs.aberration;
  origin.introduced = inputs.introduced;
  if (inputs.grey != nullptr) origin.hologram_sha256 = hash_of(*inputs.grey);
  return to_json(origin);
}

Result<ReferenceBench::Parsed> ReferenceBench::parse(const json& origin) {
  for (const char* part :
       {"sensor", "tracking", "roi", "aberration", "camera", "settings", "registration"}) {
    if (!origin.contains(part)) return fail(Errc::invalid, "origin", std::string("lacks ") + part);
  }
  // Parse the origin as a configuration, to check keys and ranges as strictly.
  const auto config = parse_config(json_text(json{{"sensor", origin["sensor"]},
                                                  {"tracking", origin["tracking"]},
                                                  {"camera", {{"roi", origin["roi"]}}}}));
  if (!config) return fail(config.error());
  auto modes = ModesSet::decode({{"modes", origin["aberration"]}});
  if (!modes) return fail(modes.error());
  auto introduced = ModesSet::decode({{"modes", origin.value("introduced", json::array())}});
  if (!introduced) return fail(introduced.error());
  auto registration = origin_registration_from(origin["registration"]);
  if (!registration) return fail(registration.error());
  const Roi& roi = config->camera.settings.roi;
  return Parsed{reference_key(config->sensor, config->tracking, roi),
                calibrated_sensor(config->sensor, config->tracking, roi), std::move(modes->modes),
                std::move(introduced->modes), *registration};
}

/// Returns the origin with its LUT and flatness checksums replaced by those of this bench.
json ReferenceBench::with_own_slm(json origin) const {
  json& slm = origin["slm"];
  for (const char* part : {"lut_sha256", "flatness_sha256"}) {
    if (slm.is_object()) slm[part] = bench_["slm"][part];
  }
  return origin;
}

bool ReferenceBench::has_other_slm_only(const json& origin) const {
  const json same = with_own_slm(origin);
  return origin.value("slm", json()) != bench_["slm"] && same["slm"] == bench_["slm"] &&
         same.value("optics", json()) == bench_["optics"];
}

std::string ReferenceBench::obstacle(const Reference& reference) const {
  if (reference.source == ReferenceSource::model) {
    // Computed positions do not depend on LUT and flatness.
    return obstacle(with_own_slm(*reference.origin), reference.key, reference.positions_px.size());
  }
  return obstacle(*reference.origin, reference.key, reference.positions_px.size());
}

std::string ReferenceBench::obstacle(const json& origin, const ReferenceKey& key,
                                     std::size_t spots) const {
  for (const char* part : {"optics", "slm"}) {
    auto differs = first_difference(part, origin.value(part, json()), bench_[part]);
    if (!differs.empty()) return differs;
  }
  HologramConfig hologram = hologram_;
  hologram.sensor = key.sensor;
  adopt_maps(hologram.sensor.masks, config_.sensor.masks);
  const auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return renderer.error().reason;
  if (renderer->lattice().subapertures.size() != spots) {
    return "its number of spots does not match its sensor";
  }
  const json hash = origin.value("hologram_sha256", json());
  if (hash.is_null()) return {};
  Image<std::uint8_t> grey;
  const auto modes = ModesSet::decode({{"modes", origin["aberration"]}});
  if (!modes) return modes.error().reason;
  renderer->render(HologramKind::sensor, modes->modes, grey);
  return hash == hash_of(grey) ? "" : "this version of the program draws its hologram differently";
}

std::string identity_of(const json& origin) {
  json identity;
  for (const char* part : {"camera", "roi", "sensor", "tracking", "optics", "slm"}) {
    identity[part] = origin.value(part, json());
  }
  // Keys of later versions count only where they are used, so that older files keep their names.
  for (const char* key : {"alternate_charge", "charges", "mask"}) {
    if (identity["sensor"].value(key, json()).empty()) identity["sensor"].erase(key);
  }
  if (const auto mask = identity["sensor"].find("mask"); mask != identity["sensor"].end()) {
    const bool one = mask->is_object();
    if (one && mask->value("subapertures", json()).empty()) mask->erase("subapertures");
  }
  return sha256_hex(json_text(identity)).substr(0, 16);
}

bool of_other_camera(const Reference& reference, const std::optional<CameraInfo>& camera) {
  if (!reference.origin || !camera) return false;
  const json& then = (*reference.origin)["camera"];
  return !then.is_null() && then != camera_json(camera);
}

std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now) {
  std::vector<StaleField> stale;
  if (reference.source == ReferenceSource::model || !reference.origin || !now) return stale;
  const json& then = (*reference.origin)["settings"];
  if (!then.is_object()) return stale;
  const json current = to_json(OriginSettings{*now});
  for (const auto& [field, value] : current.items()) {
    // A file of another program version may lack a key. Such a setting cannot be compared.
    if (then.contains(field) && then[field] != value) {
      stale.push_back({field, then[field], value});
    }
  }
  return stale;
}

}  // namespace ovws
