/// A reference as JSON, for its file.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"

namespace ovws {

/// What a file holds of a reference, and back: positions, standard errors and the picture, bit for
/// bit. Errors (Errc::invalid) say what does not fit together.
nlohmann::json reference_content(const Reference& reference);
Result<Reference> reference_from(const nlohmann::json& content);

}  // namespace ovws
