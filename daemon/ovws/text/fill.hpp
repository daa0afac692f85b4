/// Sentences as templates, which are filled in with the keys of a JSON object.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace ovws::cli {

/// The text of a template. Keys may be paths with dots ("roi.width", "base_px.0"); "." is the
/// object itself.
///
///     {rms_waves:.4f}       a value, with a format of fmt, or one of the named formats below
///     {brightest*100:.0f}   a number times, or with / divided by, a factor
///     [measured?text]       the text if the value is not null, false, 0 or empty, or is not there
///     [!measured?text]      the text otherwise
///     [state=ended?text]    if the value is this text; [closed|steps?text] if one of several holds
///     [modes:modes?text]    if the value in this format is not empty
///     [cameras*text]        the text for each item of a list, with the item's keys
///
/// Named formats: age and clock (of ns, UTC), time (s), size (bytes), modes (a list of modes),
/// mode (the name of j), signed (four decimals), list (items with commas), count (of a list's
/// items), json, and camera, exposure and gain (of camera settings).
///
/// A null is "?". A newline at the end is left out. Throws nlohmann::json::exception if a value is
/// missing, or of another type than its format.
std::string fill(std::string_view form, const nlohmann::json& values);

}  // namespace ovws::cli
