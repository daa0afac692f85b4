#include "drivers/twin/dmd.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/twin/pixel_bytes.hpp"

namespace ovws::twin {
namespace {

constexpr int kBitsPerColour = 8;
/// A pulse belongs to a time that is this much before it: rounding moves no frame to another pulse.
constexpr double kEarlyNs = 1000.0;

/// Lowest bit of each colour in a pixel, in the order of the patterns.
std::array<int, 3> colour_shifts(BitOrder order) {
  constexpr int kRed = 16, kGreen = 8, kBlue = 0;
  if (order == BitOrder::rgb) return {kRed, kGreen, kBlue};
  if (order == BitOrder::bgr) return {kBlue, kGreen, kRed};
  return {kGreen, kRed, kBlue};
}

}  // namespace

Patterns dark_patterns(const PatternMode& dmd, int width, int height) {
  return Patterns(std::size_t(std::max(1, dmd.patterns)), Image<std::uint8_t>(width, height));
}

void read_row(const PatternMode& dmd, const std::uint32_t* pixels, int y, Patterns& patterns) {
  const int width = patterns.front().width;
  if (dmd.patterns == 0) return blue_bytes(pixels, width, patterns.front().row(y));
  const auto shifts = colour_shifts(dmd.bit_order);
  for (int k = 0; k < dmd.patterns; ++k) {
    const int bit = shifts[std::size_t(k / kBitsPerColour)] + k % kBitsPerColour;
    bit_bytes(pixels, width, bit, patterns[std::size_t(k)].row(y));
  }
}

bool same_pixels(const Patterns& a, const Patterns& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& one, const auto& other) { return one.pixels == other.pixels; });
}

PatternClock::PatternClock(const PatternMode& dmd)
    : patterns_(dmd.patterns), period_ns_(dmd.cycle_ms * 1e6 / dmd.patterns) {}

std::int64_t PatternClock::time_of(std::int64_t pulse) const {
  return std::llround(static_cast<long double>(pulse) * static_cast<long double>(period_ns_));
}

std::int64_t PatternClock::last_pulse(std::int64_t t_ns) const {
  return std::int64_t(std::floor((double(t_ns) + kEarlyNs) / period_ns_));
}

std::int64_t PatternClock::next_cycle(std::int64_t t_ns) const {
  return time_of((cycle_of(last_pulse(t_ns)) + 1) * patterns_);
}

std::int64_t PatternClock::last_pulse_in(std::int64_t t_ns, double exposure_us) const {
  const double end_ns = double(t_ns) + exposure_us * 1e3 - 2.0 * kEarlyNs;
  return std::max(last_pulse(t_ns), last_pulse(std::int64_t(end_ns)));
}

Exposed PatternClock::exposed(std::int64_t t_ns, double exposure_us) const {
  const std::int64_t first = last_pulse(t_ns);
  const std::int64_t count = last_pulse_in(t_ns, exposure_us) - first + 1;
  if (count >= patterns_) return {0, patterns_};
  return {pattern_of(first), int(count)};
}

}  // namespace ovws::twin
