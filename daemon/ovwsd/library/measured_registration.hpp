/// Registration file: the measured mapping from the SLM's spatial frequencies to camera pixels.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "core/optics/geometry.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"

namespace ovws {

/// A measured registration, and the bench that it was measured on.
struct MeasuredRegistration : Registration {
  BenchKey key{};  ///< only respect::kRegistration and kRegistrationSettings
};

/// A stored registration whose array has the numbers of the present configuration: only the places
/// of the lenslets were measured, and plates if array.fit measured them for as many steps.
MeasuredRegistration array_by(const Config& config, MeasuredRegistration stored);

/// Converts a registration to the JSON content of its file, and back. Errors (Errc::invalid) name
/// the inconsistent field.
nlohmann::json registration_content(const MeasuredRegistration& registration);
Result<MeasuredRegistration> registration_from(const nlohmann::json& content);

}  // namespace ovws
