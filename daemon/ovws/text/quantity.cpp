#include "daemon/ovws/text/quantity.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws::cli {
namespace {

struct Unit {
  std::string_view name;
  double seconds;
};
constexpr std::array<Unit, 8> kUnits{{{"us", 1e-6},
                                      {"µs", 1e-6},
                                      {"μs", 1e-6},
                                      {"ms", 1e-3},
                                      {"s", 1.0},
                                      {"min", 60.0},
                                      {"h", 3600.0},
                                      {"d", 86400.0}}};

/// The finite number that the text begins with, and the rest without spaces before it.
std::optional<std::pair<double, std::string_view>> split_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(std::size_t(end - text.data()));
  while (text.starts_with(' ')) text.remove_prefix(1);
  return std::pair(value, text);
}

/// The number of a text that may have one of these units; else it is not what it should be.
Result<double> number_of(std::string_view text, std::array<std::string_view, 3> units,
                         const char* wanted) {
  const auto number = split_number(text);
  if (number && std::ranges::count(units, number->second) > 0) return number->first;
  return fail(Errc::invalid, "", fmt::format("\"{}\" is not {}", text, wanted));
}

std::string two_units(double seconds, double large, const char* large_name, double small,
                      const char* small_name) {
  const auto all = std::int64_t(seconds / small + 0.5);
  const auto ratio = std::int64_t(large / small);
  if (all % ratio == 0) return fmt::format("{} {}", all / ratio, large_name);
  return fmt::format("{} {} {} {}", all / ratio, large_name, all % ratio, small_name);
}

}  // namespace

Result<double> seconds_of(std::string_view text) {
  const auto number = split_number(text);
  if (number) {
    for (const Unit& unit : kUnits) {
      if (number->second == unit.name) return number->first * unit.seconds;
    }
    if (number->second.empty()) {
      return fail(Errc::invalid, "",
                  fmt::format("\"{0}\" has no unit: give e.g. {0}us, {0}ms or {0}s", text));
    }
  }
  return fail(Errc::invalid, "",
              fmt::format("\"{}\" is not a time: give a number with us, ms, s, min or h", text));
}

Result<double> decibels_of(std::string_view text) {
  return number_of(text, {"", "dB", "db"}, "a gain: give a number of dB");
}

Result<double> hertz_of(std::string_view text) {
  return number_of(text, {"", "Hz", "hz"}, "a frame rate: give a number of Hz");
}

std::string time_text(double seconds) {
  if (seconds == 0.0) return "0 s";
  if (seconds < 0.9995e-3) return fmt::format("{:.4g} us", 1e6 * seconds);
  if (seconds < 0.9995) return fmt::format("{:.4g} ms", 1e3 * seconds);
  if (seconds < 59.5) return fmt::format("{:.3g} s", seconds);
  if (seconds < 3599.5) return two_units(seconds, 60.0, "min", 1.0, "s");
  if (seconds < 86370.0) return two_units(seconds, 3600.0, "h", 60.0, "min");
  return two_units(seconds, 86400.0, "d", 3600.0, "h");
}

std::string age_text(std::int64_t t_ns) {
  const double age_s = 1e-9 * double(utc_ns() - t_ns);
  return age_s < 1.0 ? "just now" : time_text(std::round(age_s)) + " ago";
}

std::string size_text(double bytes) {
  for (const char* unit : {"B", "kB", "MB", "GB"}) {
    if (bytes < 999.5) return fmt::format("{:.3g} {}", bytes, unit);
    bytes /= 1e3;
  }
  return fmt::format("{:.3g} TB", bytes);
}

}  // namespace ovws::cli
