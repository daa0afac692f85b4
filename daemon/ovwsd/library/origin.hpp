/// Provenance (`origin`) of references and other measurements: the bench and settings that they
/// were made with, as JSON.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {

/// Everything that the origin (provenance record) of a measurement contains.
struct OriginInputs {
  const BenchKey& key;  ///< with the tracking settings that the measurement depends on
  const std::vector<Mode>& aberration;
  const std::optional<CameraSettings>& settings;  ///< none: unknown
  const std::optional<Registration>& registration;
  const Image<std::uint8_t>* grey = nullptr;  ///< the hologram shown; null: none was needed
  std::vector<Mode> introduced{};             ///< references: the introduced part of `aberration`
};
/// Makes the provenance record of a measurement: the field `origin` of reference.get.
nlohmann::json make_origin(const OriginInputs& inputs);

struct ParsedOrigin {
  BenchKey key;
  std::vector<Mode> aberration, introduced;
  std::optional<Registration> registration;  ///< only base_px, px_per_cycle and t_taken_ns
};
/// Parses an origin. Errors (Errc::invalid): a part is missing, or a configuration would not accept
/// it.
Result<ParsedOrigin> parse_origin(const nlohmann::json& origin);

/// Why a stored measurement with this origin cannot be used with the LUT and flatness of
/// `hologram`, with which it was made; empty: it can. Renders its hologram again, because another
/// version of the program may draw a different one. `spots`: number of spots of the measurement;
/// `configured`: masks whose maps have been read.
std::string drawing_obstacle(const nlohmann::json& origin, const BenchKey& key, std::size_t spots,
                             HologramConfig hologram, const Masks& configured);

/// Name of the file of a measurement with this origin: a hash of bench, camera, sensor, tracking
/// and region, 16 hexadecimal digits. Only one reference of each name can be active.
std::string identity_of(const nlohmann::json& origin);

/// An object that a stored measurement holds, such as its origin, in field tables.
template <>
struct Wire<std::shared_ptr<const Json>> {
  static Json to_json(const std::shared_ptr<const Json>& object) {
    return object ? *object : Json();
  }
  static void decode(ObjectReader& reader, const FieldInfo& field,
                     std::shared_ptr<const Json>& out) {
    const Json* const given = reader.raw(field.key);
    if (given == nullptr || (given->is_null() && !field.required)) return;
    if (!given->is_object()) return reader.fault(field.key, "must be an object");
    out = std::make_shared<const Json>(*given);
  }
};

/// Camera settings (gain, exposure, pixel format) that have changed since the reference was taken.
/// Such a change makes the reference stale, not invalid. Empty for a model reference, and while the
/// camera's settings are unknown.
std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now);

}  // namespace ovws
