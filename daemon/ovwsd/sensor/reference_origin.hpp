/// Where a reference comes from: what decides whether it may be used, and what only makes it stale.
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

/// What a reference is taken with.
struct OriginInputs {
  const ReferenceKey& key;
  const std::vector<Mode>& aberration;
  const std::optional<CameraSettings>& settings;  ///< none: not known
  const std::optional<CameraInfo>& camera;
  const std::optional<Registration>& registration;
  const Image<std::uint8_t>* grey = nullptr;  ///< the hologram shown; null: of the model
  std::vector<Mode> introduced{};             ///< of a reference: the part of `aberration`
};

/// None: not known.
std::optional<CameraName> camera_name(const std::optional<CameraInfo>& camera);
/// The same as JSON, or null.
nlohmann::json camera_json(const std::optional<CameraInfo>& camera);

/// The bench as the configuration says it: with another one a reference's positions mean nothing.
class ReferenceBench {
 public:
  /// `hologram`: of that configuration, whose LUT and flatness are known by their checksums.
  ReferenceBench(const Config& config, HologramConfig hologram);

  /// From now on LUT and flatness are these, in place of the configuration's.
  void use_slm(const SlmInForce& slm);

  /// "origin" of reference.get.
  nlohmann::json origin(const OriginInputs& inputs) const;
  /// Of an origin. Errors: it lacks something, or it is not that of a configuration.
  struct Known {
    ReferenceKey key;
    std::vector<Mode> aberration, introduced;
    std::optional<Registration> registration;  ///< its map and time
  };
  static Result<Known> known(const nlohmann::json& origin);

  /// Why a reference that was kept cannot be used here; empty if it can. Its hologram is rendered
  /// anew: a program that draws another one says so.
  std::string obstacle(const Reference& reference) const;
  /// The same of what else has an origin, as `known` accepts it, and as many spots.
  std::string obstacle(const nlohmann::json& origin, const ReferenceKey& key,
                       std::size_t spots) const;

  /// Whether LUT or flatness are all that is otherwise: then it may be used when they are as they
  /// were.
  bool has_other_slm_only(const nlohmann::json& origin) const;
  /// See slm_identity.
  const nlohmann::json& slm() const { return bench_["slm"]; }

  const Config& config() const { return config_; }

 private:
  nlohmann::json with_own_slm(nlohmann::json origin) const;

  Config config_;
  HologramConfig hologram_;
  nlohmann::json bench_;  ///< {optics, slm}
};

/// 16 hexadecimal digits, the same for references of which only one can be in force: of one bench,
/// camera, sensor, tracking and region.
std::string identity_of(const nlohmann::json& origin);

/// Whether both are known and differ: another camera's positions mean nothing.
bool of_other_camera(const Reference& reference, const std::optional<CameraInfo>& camera);

/// Settings that are not those it was taken with, and that its positions outlive: gain, exposure,
/// pixel format. Of a model reference none, and none while the camera's are not known.
std::vector<StaleField> stale_fields(const Reference& reference,
                                     const std::optional<CameraSettings>& now);

}  // namespace ovws
