/// Field tables of the bench's optics.
#pragma once

#include <cstdint>

#include "core/optics/geometry.hpp"
#include "proto/field_json.hpp"

namespace ovws {

/// Registration matrix (2 x 2, camera pixels per cycle per SLM pixel) as [xx, xy, yx, yy].
template <>
struct Wire<PxPerCycle> {
  static Json to_json(const PxPerCycle& map) { return {map.xx, map.xy, map.yx, map.yy}; }
  static void decode(ObjectReader& reader, const FieldInfo& field, PxPerCycle& out) {
    PxPerCycle read;
    detail::decode_tuple(reader, field, 4, [&read](const std::vector<double>& m) {
      read = {m[0], m[1], m[2], m[3]};
    });
    if (reader.failed() || !reader.has(field.key)) return;
    if (read.scale() < limits::kMinPxPerCycle) {
      return reader.fault(field.key,
                          "the scale of this matrix, sqrt |xx yy - xy yx|, is below 1: give [xx, "
                          "xy, yx, yy] in camera pixels per cycle per SLM pixel");
    }
    out = read;
  }
  static Json schema(SchemaParts&, const FieldInfo& field) {
    Json number{{"type", "number"}};
    if (std::isfinite(field.bounds.min)) number["minimum"] = field.bounds.min;
    if (std::isfinite(field.bounds.max)) number["maximum"] = field.bounds.max;
    return {{"type", "array"}, {"items", number}, {"minItems", 4}, {"maxItems", 4}};
  }
};

template <>
inline constexpr auto kTable<SlmGeometry> = Fields{
    "SlmGeometry", field("width", &SlmGeometry::width_px, "width, pixels", limits::kSlmSizePx),
    field("height", &SlmGeometry::height_px, "height, pixels", limits::kSlmSizePx),
    field<&SlmGeometry::pitch_um>("pixel pitch, micrometres", limits::kSlmPitchUm)};

template <>
inline constexpr auto kTable<OpticsConfig> =
    Fields{"OpticsConfig",
           field<&OpticsConfig::wavelength_nm>("wavelength of the laser, nanometres",
                                               limits::kWavelengthNm),
           field<&OpticsConfig::focal_length_mm>("focal length of the Fourier lens, millimetres",
                                                 limits::kFocalLengthMm),
           field<&OpticsConfig::magnification>(
               "magnification from the lens's focal plane to the camera", limits::kMagnification),
           field<&OpticsConfig::camera_pitch_um>("pixel pitch of the camera, micrometres",
                                                 limits::kCameraPitchUm),
           field<&OpticsConfig::centre_px>("[x, y] of the base subaperture's spot in the image, "
                                           "camera pixels; null: the image's centre",
                                           limits::kCentrePx),
           field("px_per_cycle", &OpticsConfig::registered,
                 "[xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by (xx u + "
                 "xy v, yx u + yy v) camera pixels; null: from the keys above, without rotation",
                 limits::kPxPerCycle)};

}  // namespace ovws
