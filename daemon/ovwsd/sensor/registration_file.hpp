/// Registration file: the measured mapping from the SLM's spatial frequencies to camera pixels.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/optics/geometry.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// A measured registration, and the camera that it was measured with.
struct MeasuredRegistration : Registration {
  nlohmann::json camera;      ///< {vendor, model, serial}; null: unknown
  std::string sha256;         ///< checksum of the file; empty: not stored
  nlohmann::json slm{};       ///< geometry of the SLM in the file; null: the configured one
  nlohmann::json settings{};  ///< registration_settings of then; null: those of now, or unknown
};

/// The configuration's values that a registration measures or builds on, by their keys.
nlohmann::json registration_settings(const Config& config);

/// A stored registration whose array has the numbers of the present configuration: only the places
/// of the lenslets were measured, and plates if array.fit measured them for as many steps.
MeasuredRegistration array_by(const Config& config, MeasuredRegistration stored);

/// Registrations of one SLM, as the item type of Kept.
struct RegistrationKind {
  using Item = MeasuredRegistration;
  static constexpr const char *kKind = "registration", *kEvent = kKind, *kTitle = kKind,
                              *kMethod = "registration.run";
  SlmGeometry slm;
  nlohmann::json settings{};  ///< registration_settings of now

  std::string name(const Item&) const { return "camera"; }
  nlohmann::json content(const Item& registration) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& registration) const;
  /// Settings that have changed since the registration: "array.pitch_um was 150.0, and is 152.0".
  std::vector<std::string> changed_settings(const Item& registration) const;
};
using KeptRegistration = Kept<RegistrationKind>;

}  // namespace ovws
