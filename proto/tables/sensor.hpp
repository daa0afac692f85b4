/// Field tables of the sensor, the optics and the trackers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/field_json.hpp"
#include "proto/tables/names.hpp"

namespace ovws {

template <>
struct Table<SensorConfig> {
  static constexpr const char* kName = "SensorConfig";
  static constexpr auto kFields = Fields{
      field("charge", &SensorConfig::charge,
            "topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor",
            limits::kCharge),
      field("grid", &SensorConfig::grid, "how the subapertures lie"),
      field("subapertures_across", &SensorConfig::subapertures_across,
            "M, along the pupil's diameter", limits::kSubaperturesAcross),
      field("pupil_diameter_px", &SensorConfig::pupil_diameter_px, "D, SLM pixels",
            limits::kPupilDiameterPx),
      field("grooves", &SensorConfig::grooves,
            "n_x, n_y: grooves of the base grating over the SLM's width and height",
            limits::kGrooves),
      field("spacing", &SensorConfig::spacing,
            "s: how far the spots are spread on the camera, grooves per SLM pixel of a "
            "subaperture's position",
            limits::kSpacing)};
};

/// Sensor and tracking settings: what `sensor.set` changes.
struct SensorSettings {
  SensorConfig sensor;
  TrackingSettings tracking;
};

template <>
struct Table<TrackingSettings> {
  static constexpr const char* kName = "TrackingSettings";
  static constexpr auto kFields = Fields{
      field("tracker", &TrackingSettings::tracker, "how spots are found"),
      field("template", &TrackingSettings::templates,
            "of the tracker matched: the model's spot, or each spot as the reference shows it"),
      field("operator", &TrackingSettings::mode_operator,
            "from displacements to modes: slopes, the tracker's own tilt of each mode; "
            "diffractive, each mode through the diffraction model, exact for aberrations up to "
            "about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the "
            "daemon refuses it; measured: each mode as the bench itself showed it to "
            "calibration.run")};
};

template <>
struct Table<SensorSettings> {
  static constexpr const char* kName = "SensorSettings";
  static constexpr auto kFields =
      Fields{inlined(&SensorSettings::sensor), inlined(&SensorSettings::tracking)};
};

/// Templates in use: a reference may not provide a template for every spot.
struct TemplateReport {
  int own = 0;         ///< spots with a template from the reference instead of the model
  std::string reason;  ///< why not all of them if requested; empty: nothing is missing
};
template <>
struct Table<TemplateReport> {
  static constexpr const char* kName = "TemplateReport";
  static constexpr auto kFields = Fields{
      field("own_templates", &TemplateReport::own,
            "spots that are found by a template of their own, from the reference, and not by the "
            "model's",
            Bounds::at_least(0)),
      field("template_reason", &TemplateReport::reason,
            "why that is not every spot though template is reference, and the way out; null: it "
            "is, or was not asked for")
          .or_null()};
};

/// The active operator from displacements to modes. The requested one may not be available yet.
struct OperatorReport {
  OperatorKind in_force = OperatorKind::slopes;
  std::string reason;  ///< why it is not the requested one; empty: it is
};
template <>
struct Table<OperatorReport> {
  static constexpr const char* kName = "OperatorReport";
  static constexpr auto kFields = Fields{
      field("operator_in_force", &OperatorReport::in_force,
            "what turns displacements into modes now"),
      field("operator_reason", &OperatorReport::reason,
            "why that is not the operator asked for: it is being made, or why it cannot be; null: "
            "it is")
          .or_null()};
};

/// Result of `sensor.get`.
struct SensorReport {
  SensorSettings settings;
  TemplateReport templates;
  OperatorReport mode_operator;
  int subapertures = 0;
  std::vector<int> modes_j;
  std::uint64_t hologram_id = 0;
};
template <>
struct Table<SensorReport> {
  static constexpr const char* kName = "SensorReport";
  static constexpr auto kFields = Fields{
      inlined(&SensorReport::settings),
      inlined(&SensorReport::templates),
      inlined(&SensorReport::mode_operator),
      field("subapertures", &SensorReport::subapertures, "how many there are", Bounds::at_least(0)),
      field("modes_j", &SensorReport::modes_j, "OSA/ANSI indices that are reconstructed",
            {1, kMaxZernikeIndex}),
      field("hologram_id", &SensorReport::hologram_id,
            "number of the hologram, as in every stream message; 0: none")};
};

}  // namespace ovws
