/// Numbers from text and to text, with a decimal point in every locale. std::stod, printf, and
/// std::to_string of a floating-point number follow the process's locale, which libraries change.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ovws {

/// The number that the whole text is, such as "-0.5", "+2" or "1e-3". None if it is anything else,
/// or not a finite number of double precision.
std::optional<double> finite_number(std::string_view text);
/// `value` with this number of decimals: "0.50".
std::string with_decimals(double value, int decimals);
/// `value` with its sign and this number of decimals: "+0.50"; "0.00" without a sign if it rounds
/// to zero.
std::string signed_decimals(double value, int decimals);
/// `value` with at most this number of significant digits: "0.5", "1e+20".
std::string with_digits(double value, int digits);

}  // namespace ovws
