/// Quantities with units, as people write and read them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.hpp"

namespace ovws::cli {

/// Seconds of a time with its unit: "2ms", "2000 us", "1.5s", "10min", "2h". A number without a
/// unit is an error that shows both meanings. Errors (Errc::invalid) have no field.
Result<double> seconds_of(std::string_view text);
/// Decibels: "12", "12dB" or "12 dB".
Result<double> decibels_of(std::string_view text);
/// The number of "100" or "100 Hz".
Result<double> hertz_of(std::string_view text);

/// A time with the unit that suits it: "2 ms", "1.5 s", "3 min 12 s", "2 h 5 min", "3 d 4 h".
std::string time_text(double seconds);
/// The time since then, "12 min ago". `t_ns`: UNIX epoch UTC.
std::string age_text(std::int64_t t_ns);
/// "812 MB", with powers of 1000.
std::string size_text(double bytes);

}  // namespace ovws::cli
