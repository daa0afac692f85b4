/// Provenance (`origin`) of references and other measurements: whether a measurement can be used on
/// this bench, and whether it is stale.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {

/// Everything that the origin (provenance record) of a measurement contains.
struct OriginInputs {
  const ReferenceKey& key;
  const std::vector<Mode>& aberration;
  const std::optional<CameraSettings>& settings;  ///< none: unknown
  const std::optional<CameraInfo>& camera;
  const std::optional<Registration>& registration;
  const Image<std::uint8_t>* grey = nullptr;  ///< the hologram shown; null: none was needed
  std::vector<Mode> introduced{};             ///< references: the introduced part of `aberration`
};

/// Vendor, model and serial number of the camera; none if the camera is unknown.
std::optional<CameraName> camera_name(const std::optional<CameraInfo>& camera);
/// Describes the first key below `path` whose value differs; empty: no difference. A missing key
/// counts as null.
std::string first_difference(const std::string& path, const nlohmann::json& then,
                             const nlohmann::json& now);
/// camera_name as JSON; null if the camera is unknown.
nlohmann::json camera_json(const std::optional<CameraInfo>& camera);

/// The configured bench (optics and SLM). A measurement of another bench cannot be used.
class ReferenceBench {
 public:
  /// `hologram`: as configured. Checksums identify its LUT and flatness.
  ReferenceBench(const Config& config, HologramConfig hologram);

  /// Replaces the configured LUT and flatness with those that the SLM uses now.
  void use_slm(const ActiveSlm& slm);

  /// Makes the provenance record of a measurement: the field `origin` of reference.get.
  nlohmann::json origin(const OriginInputs& inputs) const;
  /// Parses an origin. Errors (Errc::invalid): a part is missing, or a configuration would not
  /// accept it.
  struct Parsed {
    ReferenceKey key;
    ReferenceKey calibrated;  ///< key of a calibration that has this origin
    std::vector<Mode> aberration, introduced;
    std::optional<Registration> registration;  ///< only base_px, px_per_cycle and t_taken_ns
  };
  static Result<Parsed> parse(const nlohmann::json& origin);

  /// Why a stored reference cannot be used on this bench; empty: it can. Renders the reference's
  /// hologram again, because another version of the program may draw a different one.
  std::string obstacle(const Reference& reference) const;
  /// Why a measurement of any kind cannot be used on this bench; empty: it can. `origin` must be
  /// valid for `parse`; `spots`: number of spots of the measurement.
  std::string obstacle(const nlohmann::json& origin, const ReferenceKey& key,
                       std::size_t spots) const;

  /// Whether a measurement differs from this bench in LUT or flatness only. It can be used again
  /// once that LUT and flatness are restored.
  bool has_other_slm_only(const nlohmann::json& origin) const;
  /// Identity of the SLM with its active LUT and flatness, see slm_identity.
  const nlohmann::json& slm() const { return bench_["slm"]; }

  const Config& config() const { return config_; }

 private:
  nlohmann::json with_own_slm(nlohmann::json origin) const;

  Config config_;
  HologramConfig hologram_;
  nlohmann::json bench_;  ///< {optics, slm}
};

/// Hash of bench, camera, sensor, tracking and region, 16 hexadecimal digits. It names the file of
/// a reference, because only one reference of each identity can be active.
std::string identity_of(const nlohmann::json& origin);

/// Whether the reference was taken with another camera than `camera`; false if either camera is
/// unknown. Positions measured with another camera must not be used.
bool of_other_camera(const Reference& reference, const std::optional<CameraInfo>& camera);

/// Camera settings (gain, exposure, pixel format) that have changed since the reference was taken.
/// Such a change makes the reference stale, not invalid. Empty for a model reference, and while the
/// camera's settings are unknown.
std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now);

}  // namespace ovws
