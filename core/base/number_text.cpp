#include "core/base/number_text.hpp"

#include <array>
#include <cmath>

namespace ovws {
namespace {

constexpr std::size_t kMaxChars = 512;  // the largest double has 309 digits before its decimals

std::string written(double value, std::chars_format format, int precision) {
  std::array<char, kMaxChars> text{};
  const auto end = std::to_chars(text.begin(), text.end(), value, format, precision);
  return {text.data(), end.ptr};
}

}  // namespace

std::optional<double> finite_number(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  const auto value = number_from<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string with_decimals(double value, int decimals) {
  return written(value, std::chars_format::fixed, decimals);
}

std::string signed_decimals(double value, int decimals) {
  const std::string size = with_decimals(std::abs(value), decimals);
  if (size.find_first_not_of("0.") == std::string::npos) return size;
  return (std::signbit(value) ? "-" : "+") + size;
}

std::string with_digits(double value, int digits) {
  return written(value, std::chars_format::general, digits);
}

}  // namespace ovws
