#include "daemon/ovwsd/library/origin.hpp"

#include "config/tables.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"
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
  for (const char* key : {"t_taken_ns", "base_px", "px_per_cycle"}) {
    if (!content.is_object() || !content.contains(key)) {
      return fail(Errc::invalid, "registration", std::string("lacks ") + key);
    }
  }
  const auto read = decode<OriginRegistration>(content);
  if (!read) return fail(read.error());
  Registration registration;
  registration.base_px = read->base_px;
  registration.px_per_cycle = read->px_per_cycle;
  registration.t_taken_ns = read->t_taken_ns;
  return registration;
}

std::string hash_of(const Image<std::uint8_t>& grey) {
  return sha256_of(std::span(grey.pixels));
}

}  // namespace

json make_origin(const OriginInputs& inputs) {
  Origin origin;
  origin.program = OVWS_VERSION;
  if (inputs.settings) origin.settings = OriginSettings{*inputs.settings};
  origin.registration = of_origin(inputs.registration);
  origin.roi = inputs.key.roi;
  origin.sensor = inputs.key.sensor;
  origin.tracking.json = to_json(ConfiguredTracking(inputs.key.tracking));
  origin.optics.json = inputs.key.optics;
  origin.slm.json = inputs.key.slm;
  origin.aberration = inputs.aberration;
  origin.introduced = inputs.introduced;
  if (inputs.grey != nullptr) origin.hologram_sha256 = hash_of(*inputs.grey);
  json content = to_json(origin);
  content["camera"] = inputs.key.camera;
  return content;
}

Result<ParsedOrigin> parse_origin(const json& origin) {
  for (const char* part : {"sensor", "tracking", "roi", "optics", "slm", "aberration", "camera",
                           "settings", "registration"}) {
    if (!origin.is_object() || !origin.contains(part)) {
      return fail(Errc::invalid, "origin", std::string("lacks ") + part);
    }
  }
  // Parse the origin as a configuration, to check keys and ranges as strictly.
  const auto config = parse_config(json_text(json{{"sensor", origin["sensor"]},
                                                  {"tracking", origin["tracking"]},
                                                  {"optics", origin["optics"]},
                                                  {"camera", {{"roi", origin["roi"]}}}}));
  if (!config) return fail(config.error());
  const json& identity = origin["slm"];
  const auto slm =
      decode<SlmGeometry>(identity.is_object() ? only_fields<SlmGeometry>(identity) : json());
  if (!slm) return fail(slm.error());
  auto modes = ModesSet::decode({{"modes", origin["aberration"]}});
  if (!modes) return fail(modes.error());
  auto introduced = ModesSet::decode({{"modes", origin.value("introduced", json::array())}});
  if (!introduced) return fail(introduced.error());
  auto registration = origin_registration_from(origin["registration"]);
  if (!registration) return fail(registration.error());
  ParsedOrigin parsed{{}, std::move(modes->modes), std::move(introduced->modes), *registration};
  parsed.key.sensor = config->sensor;
  parsed.key.tracking = config->tracking;
  parsed.key.roi = config->camera.settings.roi;
  parsed.key.optics = origin["optics"];
  parsed.key.slm = identity;
  parsed.key.camera = origin["camera"];
  use_map(parsed.key, parsed.registration, config->optics, *slm);
  return parsed;
}

std::string drawing_obstacle(const json& origin, const BenchKey& key, std::size_t spots,
                             HologramConfig hologram, const Masks& configured) {
  hologram.sensor = key.sensor;
  adopt_maps(hologram.sensor.masks, configured);
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
  return sha256_hex(json_text(identity)).substr(0, 16);
}

std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now) {
  std::vector<StaleField> stale;
  if (reference.source == ReferenceSource::model || !reference.origin || !now) return stale;
  const json& then = (*reference.origin)["settings"];
  if (!then.is_object()) return stale;
  const json current = to_json(OriginSettings{*now});
  for (const auto& [field, value] : current.items()) {
    // A setting that was unknown cannot be compared.
    if (then.contains(field) && then[field] != value) {
      stale.push_back({field, then[field], value});
    }
  }
  return stale;
}

}  // namespace ovws
