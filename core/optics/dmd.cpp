#include "core/optics/dmd.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/optics/circle_columns.hpp"

namespace ovws {
namespace {

constexpr double kLeastDistance = 2.0;  // of an order from a spot, lambda/d

/// Distance of two frequencies that differ by a whole number of cycles per mirror, or nearly.
double aliased_distance(Vec2 difference_cpp) {
  return norm(Vec2{difference_cpp.x - std::round(difference_cpp.x),
                   difference_cpp.y - std::round(difference_cpp.y)});
}

/// Index of a subaperture whose order `m` falls onto a spot; -1: there is none.
int order_on_spot(const Lattice& lattice, int m) {
  const double least_cpp = kLeastDistance / lattice.diameter_px;
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const Vec2 at = double(m) * lattice.subapertures[i].frequency_cpp;
    for (const Subaperture& spot : lattice.subapertures) {
      if (aliased_distance(at - spot.frequency_cpp) < least_cpp) return int(i);
    }
  }
  return -1;
}

}  // namespace

double duty_of(double amplitude) {
  return std::asin(std::clamp(amplitude, 0.0, 1.0)) / std::numbers::pi;
}

std::uint16_t mirror_limit(double duty) {
  return std::uint16_t(std::lround(32768.0 * duty));
}

void sensor_limits_row(const DmdConfig& dmd, const Lattice& lattice, const SlmGeometry& slm, int y,
                       std::vector<std::uint16_t>& limits) {
  std::fill(limits.begin(), limits.end(), std::uint16_t(0));
  const Vec2 pupil{0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
  const double radius_px = 0.5 * lattice.diameter_px;
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const Vec2 centre = pupil + lattice.subapertures[i].centre_px;
    const Columns columns = columns_in_circle(centre, lattice.diameter_px, y, slm.width_px);
    const double amplitude = dmd.amplitudes.empty() ? 1.0 : dmd.amplitudes[i];
    for (int x = columns.begin; x < columns.end; ++x) {
      const double r = norm(Vec2{double(x), double(y)} - centre) / radius_px;
      limits[std::size_t(x)] = mirror_limit(duty_of(amplitude * (1.0 - dmd.apodisation * r * r)));
    }
  }
}

void add_pattern(const Image<std::uint8_t>& mirrors, int slot, BitOrder order,
                 Image<std::uint8_t>& rgb) {
  constexpr int kRed = 0, kGreen = 1, kBlue = 2;
  constexpr std::array<std::array<int, 3>, 3> kOrders{
      {{kGreen, kRed, kBlue}, {kRed, kGreen, kBlue}, {kBlue, kGreen, kRed}}};
  const int colour = kOrders[std::size_t(order)][std::size_t(slot / 8)];
  std::uint8_t* byte = rgb.pixels.data() + colour;
  for (const std::uint8_t level : mirrors.pixels) {
    *byte = std::uint8_t(*byte | (level >> 7) << slot % 8);
    byte += 3;
  }
}

Result<void> check_dmd(const DmdConfig& dmd, const Lattice& lattice) {
  const std::size_t given = dmd.amplitudes.size(), wanted = lattice.subapertures.size();
  if (given != 0 && given != wanted) {
    return fail(Errc::invalid, "dmd.amplitudes",
                std::to_string(given) + " amplitudes for " + std::to_string(wanted) +
                    " subapertures: give one for each, or null");
  }
  std::vector<int> orders{0, -1, 3, -3};
  if (dmd.apodisation > 0.0 || given != 0) orders.insert(orders.end(), {2, -2});
  for (const int m : orders) {
    const int i = order_on_spot(lattice, m);
    if (i < 0) continue;
    return fail(Errc::invalid, "sensor.grooves",
                "the DMD's order " + std::to_string(m) + " of subaperture " + std::to_string(i) +
                    " falls onto a spot: change the grooves, or reduce sensor.spacing");
  }
  return {};
}

}  // namespace ovws
