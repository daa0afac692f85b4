/// Provenance (`origin`) of references and other measurements: whether they can be used on this
/// bench, and whether they are stale.
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

/// Everything that the origin of a measurement records.
struct OriginInputs {
  const ReferenceKey& key;
  const std::vector<Mode>& aberration;
  const std::optional<CameraSettings>& settings;  ///< none: unknown
  const std::optional<CameraInfo>& camera;
  const std::optional<Registration>& registration;
  const Image<std::uint8_t>* grey = nullptr;  ///< the hologram shown; null: none was needed
  std::vector<Mode> introduced{};             ///< references: the introduced part of `aberration`
};

/// None: unknown.
std::optional<CameraName> camera_name(const std::optional<CameraInfo>& camera);
/// The same as JSON, or null.
nlohmann::json camera_json(const std::optional<CameraInfo>& camera);

/// The configured bench (optics and SLM). A measurement of another bench cannot be used.
class ReferenceBench {
 public:
  /// `hologram`: the configured one. Its LUT and flatness are identified by checksums.
  ReferenceBench(const Config& config, HologramConfig hologram);

  /// Replaces the configured LUT and flatness with these.
  void use_slm(const ActiveSlm& slm);

  /// The field `origin` of reference.get.
  nlohmann::json origin(const OriginInputs& inputs) const;
  /// Parses an origin. Errors (Errc::invalid): a part is missing, or is not valid in a
  /// configuration.
  struct Parsed {
    ReferenceKey key;
    ReferenceKey calibrated;  ///< the key if it is of a calibration
    std::vector<Mode> aberration, introduced;
    std::optional<Registration> registration;  ///< base, map and time only
  };
  static Result<Parsed> parse(const nlohmann::json& origin);

  /// Why a stored reference cannot be used on this bench; empty: it can. Renders its hologram
  /// again, because another version of the program may draw it differently.
  std::string obstacle(const Reference& reference) const;
  /// The same for any measurement whose origin `parse` accepts. `spots`: how many it has.
  std::string obstacle(const nlohmann::json& origin, const ReferenceKey& key,
                       std::size_t spots) const;

  /// Whether only LUT or flatness differ from this bench. Such a measurement can be used once they
  /// are restored.
  bool has_other_slm_only(const nlohmann::json& origin) const;
  /// Identity of the active SLM settings, see slm_identity.
  const nlohmann::json& slm() const { return bench_["slm"]; }

  const Config& config() const { return config_; }

 private:
  nlohmann::json with_own_slm(nlohmann::json origin) const;

  Config config_;
  HologramConfig hologram_;
  nlohmann::json bench_;  ///< {optics, slm}
};

/// Hash of bench, camera, sensor, tracking and region, 16 hexadecimal digits. Only one reference of
/// each identity can be active, so it names the file.
std::string identity_of(const nlohmann::json& origin);

/// Whether both cameras are known and differ. Positions of another camera must not be used.
bool of_other_camera(const Reference& reference, const std::optional<CameraInfo>& camera);

/// Camera settings (gain, exposure, pixel format) that have changed since the reference was taken.
/// They make it stale, not invalid. Empty for a model reference, and while the camera's settings
/// are unknown.
std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now);

}  // namespace ovws
