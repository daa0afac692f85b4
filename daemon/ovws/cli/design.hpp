/// The camera of a bench that ovws design and ovws advise are given.
#pragma once

#include <string>

#include "daemon/ovws/design/design.hpp"

namespace ovws::cli {

/// `text`: the name of a model, or "WIDTHxHEIGHT@PITCH". Errors (Errc::invalid, field "--camera"):
/// no known model and no valid size, with the nearest name.
Result<void> set_camera(design::Bench& bench, const std::string& text);

}  // namespace ovws::cli
