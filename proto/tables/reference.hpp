/// Field tables of references and registrations.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/wavefront/registration.hpp"
#include "proto/field_json.hpp"
#include "proto/names.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/sensor.hpp"
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
inline constexpr auto kTable<StaleField> = Fields{
    "StaleField", field<&StaleField::field>("key of camera.set"),
    field<&StaleField::then>("value when it was taken"), field<&StaleField::now>("value in use")};

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
inline constexpr auto kTable<ReferenceReport> =
    Fields{"ReferenceReport",
           field<&ReferenceReport::source>(
               "measured: averaged from frames; model: predicted by the configuration or the "
               "registration, so that the coefficients include misalignment")
               .among(texts<"measured", "model">),
           field<&ReferenceReport::frames>("number of averaged frames", Bounds::at_least(0)),
           field<&ReferenceReport::charge>("charge that it was taken with", limits::kCharge),
           field<&ReferenceReport::tracker>("tracker that it was taken with"),
           field<&ReferenceReport::t_taken_ns>(kTimeMeaning),
           time_text("t_taken", &ReferenceReport::t_taken_ns),
           field<&ReferenceReport::positions_px>(
               "[x, y] of each subaperture's spot, camera pixels of the region of interest")
               .with_nulls(),
           field<&ReferenceReport::standard_error_px>(
               "[x, y] standard error of each position, camera pixels; null: the spot was lost and "
               "is not used, its position is the expected one")
               .with_nulls(),
           field<&ReferenceReport::sha256>(kSha256Meaning).or_null(),
           field<&ReferenceReport::introduced_rms_waves>(
               "RMS of the introduced aberration that the reference contains and coefficients "
               "therefore exclude, waves; 0: none",
               Bounds::at_least(0)),
           field<&ReferenceReport::stale>(
               "camera settings that have changed since it was taken; the reference stays active")
               .if_absent("[]"),
           field<&ReferenceReport::origin>("bench and settings that it was taken with")};

/// Result of `reference.get`, `reference.set` and `reference.clear`.
struct KnownReference {
  std::optional<ReferenceReport> reference;
};
template <>
inline constexpr auto kTable<KnownReference> =
    Fields{"KnownReference",
           computed(
               "taken", [](auto& known) { return known.reference.has_value(); },
               "whether there is a reference; if not, all other keys are null or empty"),
           inlined(&KnownReference::reference)};

template <>
inline constexpr auto kTable<FoundArray> = Fields{
    "FoundArray",
    field<&FoundArray::lit>("number of lit lenslets in the image", {0, 1e6}),
    field<&FoundArray::subapertures_across>("lenslets across the pupil", {1, 1000}),
    field<&FoundArray::magnification>("from the array's focal plane to the camera", {1e-6, 1e6}),
    field<&FoundArray::pupil_diameter_px>("diameter of the pupil, camera pixels",
                                          limits::kLensletWidthPx),
    field<&FoundArray::plate_fitted>(
        "whether array.fit measured the spiral plates; if not, they are those of array.plate")
        .if_absent("false"),
    field<&FoundArray::lenslets>("lenslets in use, as in sensor.get")};

template <>
inline constexpr auto kTable<Registration> = Fields{
    "Registration",
    field<&Registration::t_taken_ns>(kTimeMeaning),
    field<&Registration::base_px>(
        "[x, y] of the base subaperture's spot, pixels of the camera's whole sensor"),
    field<&Registration::base_standard_error_px>("[x, y] standard error of base_px, camera pixels"),
    field<&Registration::px_per_cycle>("[xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel "
                                       "moves a spot by (xx u + xy v, yx u + yy v) camera pixels"),
    field("px_per_cycle_standard_error", &Registration::standard_error,
          "standard errors of px_per_cycle, camera pixels per cycle per SLM pixel"),
    computed(
        "scale_px_per_cycle", [](auto& r) { return r.px_per_cycle.scale(); },
        "scale of the map: square root of its determinant, camera pixels per cycle per SLM pixel"),
    computed(
        "rotation_deg", [](auto& r) { return r.px_per_cycle.rotation_deg(); },
        "rotation of the SLM's +x towards the camera's +y, as the camera sees it, degrees"),
    computed(
        "mirrored", [](auto& r) { return r.px_per_cycle.mirrored(); },
        "whether the camera sees the SLM mirrored"),
    field<&Registration::residual_px>(
        "RMS residual of the map at the positions where the spot was found, camera pixels",
        Bounds::at_least(0)),
    field<&Registration::sights>("number of test gratings (slopes) at which the spot was found; of "
                                 "a fixed array, lit lenslets",
                                 Bounds::at_least(0)),
    computed(
        "array",
        [](auto& r) { return r.array.empty() ? std::nullopt : std::optional<FoundArray>(r.array); },
        "the array of lenslets that was found; left out: the sensor has an SLM")
        .or_left_out()};

/// Result of the `array.fit` job.
struct ArrayFitReport {
  int levels = 0;
  double depth = 1.0, depth_standard_error = 0.0;
  Vec2 shift_um, shift_standard_error_um;
  double misfit = 0.0;
  int spots = 0;
};
template <>
inline constexpr auto kTable<ArrayFitReport> = Fields{
    "ArrayFitReport",
    field<&ArrayFitReport::levels>("steps of a turn, as configured (array.plate.levels)",
                                   limits::kPlateLevels),
    field<&ArrayFitReport::depth>("depth of the plates relative to the design",
                                  limits::kPlateDepth),
    field<&ArrayFitReport::depth_standard_error>("standard error of depth", Bounds::at_least(0)),
    field<&ArrayFitReport::shift_um>(
        "[x, y] of the plates' axes from the lenslets' centres along the lattice, micrometres"),
    field<&ArrayFitReport::shift_standard_error_um>("standard errors of shift_um, micrometres"),
    field<&ArrayFitReport::misfit>(
        "what the fit leaves of the spots' light, RMS over RMS: noise and errors of the model",
        Bounds::at_least(0)),
    field<&ArrayFitReport::spots>("number of spots fitted", Bounds::at_least(0))};

/// Result of `registration.get`, `registration.clear` and the `registration.run` job.
struct KnownRegistration {
  std::optional<Registration> registration;
};
template <>
inline constexpr auto kTable<KnownRegistration> =
    Fields{"KnownRegistration",
           computed(
               "registered", [](auto& known) { return known.registration.has_value(); },
               "whether a registration is active; if not, all other keys are null"),
           inlined(&KnownRegistration::registration)};

}  // namespace ovws
