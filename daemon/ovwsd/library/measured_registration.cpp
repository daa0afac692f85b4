#include "daemon/ovwsd/library/measured_registration.hpp"

#include <vector>

#include "config/tables.hpp"
#include "proto/limits.hpp"
#include "proto/reader.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr double kMaxPx = 1e5;     ///< limit of the base spot: far beyond any camera sensor
constexpr double kMaxCpp = 0.5;    ///< limit of the grating: the Nyquist limit of the SLM
constexpr double kMaxScale = 1e6;  ///< limit of px_per_cycle

/// Parses the keys of registration.get and also base_grating_cpp. This is the grating, in cycles
/// per SLM pixel, at which base_px was measured.
Result<Registration> numbers_from(const json& content) {
  Registration out;
  std::vector<double> base, base_error, map, error, grating;
  ObjectReader r(content, "registration");
  const auto list = [&r](const char* key, std::vector<double>& to, std::size_t size, double max) {
    r.require(key);
    r.numbers(key, to, size, size, -max, max);
  };
  list("base_px", base, 2, kMaxPx);
  list("base_standard_error_px", base_error, 2, kMaxPx);
  list("base_grating_cpp", grating, 2, kMaxCpp);
  list("px_per_cycle", map, 4, kMaxScale);
  list("px_per_cycle_standard_error", error, 4, kMaxScale);
  r.require("residual_px");
  r.number("residual_px", out.residual_px, 0.0, kMaxPx);
  r.require("sights");
  r.integer("sights", out.sights, 0, 1 << 20);
  for (const char* key : {"registered", "scale_px_per_cycle", "rotation_deg", "mirrored"}) {
    r.raw(key);
  }
  if (r.has("array")) {
    r.object("array", [&out](ObjectReader& inner) { detail::decode_fields(inner, out.array); });
  }
  const json* const taken = r.raw("t_taken_ns");
  if (taken != nullptr && taken->is_number_integer()) out.t_taken_ns = taken->get<std::int64_t>();
  if (auto done = r.finish(); !done) return fail(done.error());
  out.base_px = {base[0], base[1]};
  out.base_standard_error_px = {base_error[0], base_error[1]};
  out.base_cpp = {grating[0], grating[1]};
  out.px_per_cycle = {map[0], map[1], map[2], map[3]};
  out.standard_error = {error[0], error[1], error[2], error[3]};
  if (out.px_per_cycle.scale() < limits::kMinPxPerCycle) {
    return fail(Errc::invalid, "registration.px_per_cycle",
                "has a scale below 1 camera pixel per cycle per SLM pixel");
  }
  return out;
}

}  // namespace

MeasuredRegistration array_by(const Config& config, MeasuredRegistration stored) {
  FoundArray& array = stored.array;
  if (array.empty() || config.modulator != Modulator::fixed) {
    array = {};
    return stored;
  }
  const Lenslets before = array.lenslets;
  array.magnification = magnification_of(config, before.width_px);
  const SensorConfig sensor = sensor_with(
      config, {before.width_px, before.rotation_deg, array.pupil_diameter_px, before.centres_px});
  array.lenslets = sensor.lenslets;
  // array.fit measures depth and shift for the configured number of steps.
  array.plate_fitted = array.plate_fitted && before.plate.levels == array.lenslets.plate.levels;
  if (array.plate_fitted) array.lenslets.plate = before.plate;
  array.subapertures_across = sensor.subapertures_across;
  stored.px_per_cycle = stored.px_per_cycle.scaled_to(sensor.lenslets.px_per_cycle);
  return stored;
}

json registration_content(const MeasuredRegistration& registration) {
  json numbers = to_json(KnownRegistration{registration});
  numbers["base_grating_cpp"] = to_json(registration.base_cpp);
  return {{"registration", numbers},
          {"slm", only_fields<SlmGeometry>(registration.key.slm)},
          {"camera", registration.key.camera},
          {"optics", registration.key.optics},
          {"array", registration.key.array}};
}

Result<MeasuredRegistration> registration_from(const json& content) {
  if (!content.is_object() || !content.contains("registration") || !content.contains("slm")) {
    return fail(Errc::invalid, "", "it contains no registration");
  }
  auto numbers = numbers_from(content["registration"]);
  if (!numbers) return fail(numbers.error());
  MeasuredRegistration registration{*numbers};
  registration.key.slm = content["slm"];
  registration.key.camera = content.value("camera", json());
  registration.key.optics = content.value("optics", json());
  registration.key.array = content.value("array", json());
  return registration;
}

}  // namespace ovws
