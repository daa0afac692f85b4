/// Field tables of references and registrations.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/wavefront/registration.hpp"
#include "proto/field_json.hpp"
#include "proto/tables/names.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

inline constexpr const char* kSha256Meaning =
    "SHA-256 of the file in which it survives a restart; null: not stored, status (store) reports "
    "why";

/// A camera setting that has changed since the reference was taken.
struct StaleField {
  std::string field;
  Json then, now;
};
template <>
struct Table<StaleField> {
  static constexpr const char* kName = "StaleField";
  static constexpr auto kFields =
      Fields{field("field", &StaleField::field, "key of camera.set"),
             field("then", &StaleField::then, "value when it was taken"),
             field("now", &StaleField::now, "value in use")};
};

struct ReferenceReport {
  int frames = 0;
  int charge = 1;
  TrackerKind tracker = TrackerKind::lg;
  std::int64_t t_taken_ns = 0;
  std::vector<Vec2> positions_px;
  std::vector<Vec2> standard_error_px;
  std::string source = "measured";  ///< or "model"
  std::string sha256;               ///< empty: not stored on disk
  std::vector<StaleField> stale;
  JsonOf<Origin> origin;
  double introduced_rms_waves = 0.0;
};
template <>
struct Table<ReferenceReport> {
  static constexpr const char* kName = "ReferenceReport";
  static constexpr auto kFields = Fields{
      field("source", &ReferenceReport::source,
            "measured: averaged from frames; model: predicted by the configuration or the "
            "registration, so that the coefficients include misalignment")
          .among([] {
            return std::vector<std::string>{"measured", "model"};
          }),
      field("frames", &ReferenceReport::frames, "number of averaged frames", Bounds::at_least(0)),
      field("charge", &ReferenceReport::charge, "charge that it was taken with", limits::kCharge),
      field("tracker", &ReferenceReport::tracker, "tracker that it was taken with"),
      field("t_taken_ns", &ReferenceReport::t_taken_ns, kTimeMeaning),
      time_text("t_taken", &ReferenceReport::t_taken_ns),
      field("positions_px", &ReferenceReport::positions_px,
            "[x, y] of each subaperture's spot, camera pixels of the region of interest")
          .with_nulls(),
      field("standard_error_px", &ReferenceReport::standard_error_px,
            "[x, y] standard error of each position, camera pixels; null: the spot was lost and is "
            "not used, its position is the expected one")
          .with_nulls(),
      field("sha256", &ReferenceReport::sha256, kSha256Meaning).or_null(),
      field("introduced_rms_waves", &ReferenceReport::introduced_rms_waves,
            "RMS of the introduced aberration that the reference contains and coefficients "
            "therefore exclude, waves; 0: none",
            Bounds::at_least(0)),
      field("stale", &ReferenceReport::stale,
            "camera settings that have changed since it was taken; the reference stays active")
          .if_absent("[]"),
      field("origin", &ReferenceReport::origin, "bench and settings that it was taken with")};
};

/// Result of `reference.get`, `reference.set` and `reference.clear`.
struct KnownReference {
  std::optional<ReferenceReport> reference;
};
template <>
struct Table<KnownReference> {
  static constexpr const char* kName = "KnownReference";
  static constexpr auto kFields =
      Fields{computed<KnownReference>(
                 "taken", [](const KnownReference& known) { return known.reference.has_value(); },
                 "whether there is a reference; if not, all other keys are null or empty"),
             inlined(&KnownReference::reference)};
};

template <>
struct Table<Registration> {
  static constexpr const char* kName = "Registration";
  static constexpr auto kFields = Fields{
      field("t_taken_ns", &Registration::t_taken_ns, kTimeMeaning),
      field("base_px", &Registration::base_px,
            "[x, y] of the base subaperture's spot, pixels of the camera's whole sensor"),
      field("base_standard_error_px", &Registration::base_standard_error_px,
            "[x, y] standard error of base_px, camera pixels"),
      field("px_per_cycle", &Registration::px_per_cycle,
            "[xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by "
            "(xx u + xy v, yx u + yy v) camera pixels"),
      field("px_per_cycle_standard_error", &Registration::standard_error,
            "standard errors of px_per_cycle, camera pixels per cycle per SLM pixel"),
      computed<Registration>(
          "scale_px_per_cycle", [](const Registration& r) { return r.px_per_cycle.scale(); },
          "scale of the map: square root of its determinant, camera pixels per cycle per SLM "
          "pixel"),
      computed<Registration>(
          "rotation_deg", [](const Registration& r) { return r.px_per_cycle.rotation_deg(); },
          "rotation of the SLM's +x towards the camera's +y, as the camera sees it, degrees"),
      computed<Registration>(
          "mirrored", [](const Registration& r) { return r.px_per_cycle.mirrored(); },
          "whether the camera sees the SLM mirrored"),
      field("residual_px", &Registration::residual_px,
            "RMS residual of the map at the positions where the spot was found, camera pixels",
            Bounds::at_least(0)),
      field("sights", &Registration::sights, "number of slopes for which the spot was found",
            Bounds::at_least(0))};
};

/// Result of `registration.get`, `registration.clear` and the `registration.run` job.
struct KnownRegistration {
  std::optional<Registration> registration;
};
template <>
struct Table<KnownRegistration> {
  static constexpr const char* kName = "KnownRegistration";
  static constexpr auto kFields =
      Fields{computed<KnownRegistration>(
                 "registered",
                 [](const KnownRegistration& known) { return known.registration.has_value(); },
                 "whether a registration is active; if not, all other keys are null"),
             inlined(&KnownRegistration::registration)};
};

}  // namespace ovws
