/// Field tables of the sensor, the optics and the trackers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/optics/lattice.hpp"
#include "proto/field_json.hpp"
#include "proto/names.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {

template <>
inline constexpr NamesOf kNames<LensletShape> = texts<"square", "hexagon", "circle">;

template <>
inline constexpr auto kTable<SpiralPlate> = Fields{
    "SpiralPlate", field<&SpiralPlate::levels>("steps of a turn; 0: smooth", limits::kPlateLevels),
    field<&SpiralPlate::depth>("depth relative to the design", limits::kPlateDepth),
    field<&SpiralPlate::shift_px>(
        "[x, y] of the axis from the lenslet's centre along the lattice's axes, camera pixels",
        limits::kPlateShiftPx)};

template <>
inline constexpr auto kTable<Lenslets> =
    Fields{"Lenslets",
           field<&Lenslets::shape>("shape of a lenslet"),
           field<&Lenslets::width_px>("width of a lenslet, camera pixels", limits::kLensletWidthPx),
           field<&Lenslets::rotation_deg>(
               "rotation of the lattice from the array's +x towards its +y, degrees"),
           field<&Lenslets::plate>("the spiral phase plate in each lenslet"),
           field<&Lenslets::px_per_cycle>(
               "displacement of a spot for a slope of one cycle per camera pixel, camera pixels",
               limits::kLensletPxPerCycle),
           field<&Lenslets::centres_px>(
               "[x, y] of each lenslet in use from the pupil's centre along the array's axes, "
               "camera pixels",
               limits::kLensletPlacePx)
               .sized(1, kMaxSubapertures)};

template <>
inline constexpr auto kTable<MaskConfig> = Fields{
    "MaskConfig",
    field<&MaskConfig::modes>("Zernike modes over each subaperture, RMS-normalised").sized(0, 45),
    field<&MaskConfig::axicon_waves>(
        "RMS of a cone: phase proportional to the distance from the subaperture's centre, waves",
        limits::kMaskWaves),
    field<&MaskConfig::file>(
        "file of a phase map over the square around a subaperture; null: none. Read with the "
        "configuration file, which alone names new ones"),
    field<&MaskConfig::sha256>("SHA-256 of the map as float32; null: not known").or_null(),
    field<&MaskConfig::subapertures>(
        "indices of the subapertures that have the mask, by rows; []: all",
        {0, kMaxSubapertures - 1})
        .sized(0, kMaxSubapertures)};

/// Null, one object, or an array of objects.
template <>
struct Wire<Masks> {
  static Json to_json(const Masks& masks) {
    if (masks.empty()) return {};
    if (masks.size() == 1) return ovws::to_json(masks.front());
    Json all = Json::array();
    for (const MaskConfig& mask : masks) all.push_back(ovws::to_json(mask));
    return all;
  }
  static void decode(ObjectReader& reader, const FieldInfo& field, Masks& out) {
    const Json* const given = reader.raw(field.key);
    if (given == nullptr) return;
    Masks read;
    if (given->is_array()) {
      reader.objects(field.key, kMaxMasks, [&read](ObjectReader& inner, std::size_t) {
        detail::decode_fields(inner, read.emplace_back());
      });
    } else if (!given->is_object() && !given->is_null()) {
      return reader.fault(field.key, "must be an object, an array of objects, or null");
    } else if (given->is_object()) {
      reader.object(field.key, [&read](ObjectReader& inner) {
        detail::decode_fields(inner, read.emplace_back());
      });
    }
    if (!reader.failed()) out = std::move(read);
  }
  static Json schema(SchemaParts& parts, const FieldInfo&);
};

template <>
inline constexpr auto kTable<SensorConfig> = Fields{
    "SensorConfig",
    field<&SensorConfig::charge>(
        "topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor",
        limits::kCharge),
    field<&SensorConfig::grid>("arrangement of the subapertures"),
    field<&SensorConfig::subapertures_across>(
        "M: number of subapertures across the pupil's diameter", limits::kSubaperturesAcross),
    field<&SensorConfig::pupil_diameter_px>("D: diameter of the pupil, SLM pixels",
                                            limits::kPupilDiameterPx),
    field<&SensorConfig::grooves>(
        "n_x, n_y: grooves of the base grating over the SLM's width and height", limits::kGrooves),
    field<&SensorConfig::spacing>(
        "s: spread of the spots on the camera, grooves per SLM pixel of a subaperture's position",
        limits::kSpacing),
    field<&SensorConfig::alternate_charge>(
        "charge of every second subaperture; null: that of all others", limits::kCharge),
    field<&SensorConfig::charges>(
        "charge of each subaperture, by rows; []: all as charge and alternate_charge say",
        limits::kCharge)
        .sized(0, kMaxSubapertures),
    field("mask", &SensorConfig::masks,
          "phase that subapertures add to their vortex: one mask, or an array of masks, of which "
          "each subaperture has the sum of those that name it; null: none"),
    field<&SensorConfig::lenslets>(
        "the lenslets in use of a fixed array, as registration.run found them; left out: the SLM "
        "makes the subapertures")
        .or_left_out()};

/// Sensor and tracking settings: what `sensor.set` changes.
struct SensorSettings {
  SensorConfig sensor;
  TrackingSettings tracking;
};

template <>
inline constexpr auto kTable<TrackingSettings> =
    Fields{"TrackingSettings", field<&TrackingSettings::tracker>("algorithm that finds the spots"),
           field("operator", &TrackingSettings::mode_operator,
                 "matrix from displacements to modes: slopes, from each mode's local tilt as the "
                 "tracker measures it; measured, the interaction (poke) matrix of "
                 "calibration.run"),
           field<&TrackingSettings::mode_count>(
               "number of modes, j = 1 to this; null: as many as the positions of the spots "
               "determine. The tracker fit measures more, as far as the shapes of the spots "
               "determine them; frames are then valid only while templates describe them",
               {1, kMaxZernikeIndex}),
           field<&TrackingSettings::estimates>("numbers that the tracker fit takes from each spot: "
                                               "2 give its position, 4 also its astigmatism",
                                               limits::kEstimates)};
template <>
inline constexpr auto kTable<SensorSettings> =
    Fields{"SensorSettings", inlined(&SensorSettings::sensor), inlined(&SensorSettings::tracking)};

/// Active operator (matrix) from spot displacements to modes. It differs from the requested
/// operator while that is not available.
struct OperatorReport {
  OperatorKind in_force = OperatorKind::slopes;
  std::string reason;  ///< why the requested one is not active; empty: it is
};
template <>
inline constexpr auto kTable<OperatorReport> =
    Fields{"OperatorReport",
           field("operator_in_force", &OperatorReport::in_force,
                 "active matrix from displacements to modes"),
           field("operator_reason", &OperatorReport::reason,
                 "why the requested operator is not active; null: it is active")
               .or_null()};

/// Result of `sensor.get`.
struct SensorReport {
  SensorSettings settings;
  OperatorReport mode_operator;
  int subapertures = 0;
  std::vector<int> modes_j;
  std::uint64_t hologram_id = 0;
};
template <>
inline constexpr auto kTable<SensorReport> =
    Fields{"SensorReport",
           inlined(&SensorReport::settings),
           inlined(&SensorReport::mode_operator),
           field<&SensorReport::subapertures>("number of subapertures", Bounds::at_least(0)),
           field<&SensorReport::modes_j>("OSA/ANSI indices of the reconstructed modes",
                                         {1, kMaxZernikeIndex}),
           field<&SensorReport::hologram_id>(
               "number of the hologram, as in every stream message; 0: none")};

}  // namespace ovws
