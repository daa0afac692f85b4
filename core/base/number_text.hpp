/// Numbers from text and to text, with a decimal point in every locale. std::stod, printf, and
/// std::to_string of a floating-point number follow the process's locale, which libraries change.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace ovws {

/// The number that the whole text is. None if it is anything else, or too large. `base`: of a whole
/// number.
template <class T, class... Base>
std::optional<T> number_from(std::string_view text, Base... base) {
  T value{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value, base...);
  return error == std::errc() && end == last ? std::optional(value) : std::nullopt;
}
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
