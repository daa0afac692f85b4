#include "core/optics/lattice.hpp"

#include <algorithm>
#include <string>

#include "core/base/number_text.hpp"

namespace ovws {
namespace {

/// Relative tolerance, so that rounding does not drop a subaperture that touches the pupil's edge.
constexpr double kTouch = 1e-9;

/// Centres of the subapertures, sorted by y, then x. The base is at the pupil's centre.
std::vector<Vec2> centres(const SensorConfig& sensor, double diameter_px) {
  const bool hexagonal = sensor.grid == Grid::hexagonal;
  const double row_pitch = diameter_px * (hexagonal ? std::sqrt(0.75) : 1.0);
  const double reach = 0.5 * (sensor.pupil_diameter_px - diameter_px) * (1.0 + kTouch);
  const int rows = static_cast<int>(reach / row_pitch);
  const int cols = static_cast<int>(reach / diameter_px) + 1;
  std::vector<Vec2> found;
  for (int row = -rows; row <= rows; ++row) {
    const double shift = hexagonal && row % 2 != 0 ? 0.5 : 0.0;
    for (int col = -cols; col <= cols; ++col) {
      const Vec2 centre{(col + shift) * diameter_px, row * row_pitch};
      if (norm(centre) <= reach) found.push_back(centre);
    }
  }
  return found;
}

Vec2 frequency(Vec2 centre_px, const SensorConfig& sensor, const SlmGeometry& slm) {
  return {(sensor.grooves[0] + sensor.spacing * centre_px.x) / slm.width_px,
          (sensor.grooves[1] + sensor.spacing * centre_px.y) / slm.height_px};
}

/// Charge of subaperture i, which is at `centre_px`, see make_lattice.
int charge_at(std::size_t i, Vec2 centre_px, const SensorConfig& sensor, double diameter_px) {
  if (!sensor.charges.empty()) return sensor.charges[i];
  if (!sensor.alternate_charge) return sensor.charge;
  const bool hexagonal = sensor.grid == Grid::hexagonal;
  const double row_pitch = diameter_px * (hexagonal ? std::sqrt(0.75) : 1.0);
  const long row = std::lround(centre_px.y / row_pitch);
  const long column = hexagonal ? 0 : std::lround(centre_px.x / diameter_px);
  return (row + column) % 2 == 0 ? sensor.charge : *sensor.alternate_charge;
}

Result<void> check_pupil(const SensorConfig& sensor, const SlmGeometry& slm) {
  if (slm.width_px < 1 || slm.height_px < 1) {
    return fail(Errc::invalid, "slm.width", "the SLM must be at least 1 x 1 pixel");
  }
  const int fits = std::min(slm.width_px, slm.height_px);
  if (!(sensor.pupil_diameter_px > 0.0 && sensor.pupil_diameter_px <= fits)) {
    return fail(Errc::invalid, "sensor.pupil_diameter_px",
                "the pupil does not fit on the SLM: set more than 0 and at most " +
                    std::to_string(fits) + " pixels");
  }
  if (sensor.subapertures_across < 1 || sensor.subapertures_across > kMaxSubapertures) {
    return fail(Errc::invalid, "sensor.subapertures_across",
                "must be from 1 to " + std::to_string(kMaxSubapertures));
  }
  return {};
}

Result<void> check_count(std::size_t count) {
  if (count < kMinSubapertures) {
    return fail(Errc::invalid, "sensor.subapertures_across",
                "only " + std::to_string(count) + " subapertures fit in the pupil, but at least " +
                    std::to_string(kMinSubapertures) + " are required: increase the number across");
  }
  if (count > kMaxSubapertures) {
    return fail(Errc::invalid, "sensor.subapertures_across",
                std::to_string(count) + " subapertures exceed the maximum of " +
                    std::to_string(kMaxSubapertures) + ": reduce the number across");
  }
  return {};
}

Result<void> check_charges(const SensorConfig& sensor, std::size_t count) {
  if (sensor.charges.empty()) return {};
  if (sensor.alternate_charge) {
    return fail(Errc::invalid, "sensor.charges",
                "gives every charge: set sensor.alternate_charge to null");
  }
  if (sensor.charges.size() == count) return {};
  return fail(Errc::invalid, "sensor.charges",
              "has " + std::to_string(sensor.charges.size()) + " charges for " +
                  std::to_string(count) +
                  " subapertures: give one for each, by rows, or [] for sensor.charge in all");
}

/// The lattice of a fixed array.
Result<Lattice> lattice_of(const SensorConfig& sensor) {
  const Lenslets& lenslets = sensor.lenslets;
  const bool masked = !sensor.masks.empty();
  if (sensor.alternate_charge || masked) {
    return fail(Errc::invalid, masked ? "sensor.mask" : "sensor.alternate_charge",
                "a fixed array has one kind of plate in all lenslets: set null");
  }
  if (!sensor.charges.empty()) {
    return fail(Errc::invalid, "sensor.charges",
                "a fixed array has one kind of plate in all lenslets: set []");
  }
  if (!(lenslets.width_px > 0.0 && lenslets.px_per_cycle > 0.0)) {
    return fail(Errc::invalid, "sensor.lenslets", "width_px and px_per_cycle must be above 0");
  }
  if (lenslets.centres_px.size() < kMinSubapertures) {
    return fail(Errc::invalid, "sensor.lenslets",
                "only " + std::to_string(lenslets.centres_px.size()) +
                    " lenslets are in use, but at least " + std::to_string(kMinSubapertures) +
                    " are required: enlarge the light's diameter or the camera's region");
  }
  if (lenslets.centres_px.size() > kMaxSubapertures) {
    return fail(Errc::invalid, "sensor.lenslets",
                std::to_string(lenslets.centres_px.size()) + " lenslets exceed the maximum of " +
                    std::to_string(kMaxSubapertures) + ": set a smaller array.pupil_mm");
  }
  Lattice lattice{lenslets.diameter_px(), {}};
  for (const Vec2 centre : lenslets.centres_px) {
    lattice.subapertures.push_back({centre, (1.0 / lenslets.px_per_cycle) * centre, sensor.charge});
  }
  return lattice;
}

}  // namespace

Result<Lattice> make_lattice(const SensorConfig& sensor, const SlmGeometry& slm) {
  if (!sensor.lenslets.empty()) return lattice_of(sensor);
  if (auto ok = check_pupil(sensor, slm); !ok) return fail(ok.error());
  Lattice lattice;
  lattice.diameter_px = subaperture_diameter_px(sensor);
  const auto found = centres(sensor, lattice.diameter_px);
  if (auto ok = check_count(found.size()); !ok) return fail(ok.error());
  if (auto ok = check_charges(sensor, found.size()); !ok) return fail(ok.error());
  if (auto ok = check_masks(sensor.masks, found.size()); !ok) return fail(ok.error());
  for (const Vec2 centre : found) {
    const Vec2 f = frequency(centre, sensor, slm);
    if (!(std::abs(f.x) <= kNyquistCpp && std::abs(f.y) <= kNyquistCpp)) {
      return fail(Errc::invalid, "sensor.grooves",
                  "the grating of subaperture " + std::to_string(lattice.subapertures.size()) +
                      " has " + with_decimals(f.x, 6) + " x " + with_decimals(f.y, 6) +
                      " cycles per SLM pixel, but the limit is 0.5: reduce grooves or spacing");
    }
    const std::size_t i = lattice.subapertures.size();
    lattice.subapertures.push_back({centre, f, charge_at(i, centre, sensor, lattice.diameter_px)});
  }
  return lattice;
}

std::vector<int> charges_of(const Lattice& lattice) {
  std::vector<int> charges;
  for (const Subaperture& s : lattice.subapertures) charges.push_back(s.charge);
  return charges;
}

Vec2 base_grating_cpp(const SensorConfig& sensor, const SlmGeometry& slm) {
  return frequency({0.0, 0.0}, sensor, slm);
}

std::vector<Vec2> model_spots_px(const Lattice& lattice, const SensorConfig& sensor,
                                 const SlmGeometry& slm, const OpticsConfig& optics, int image_cols,
                                 int image_rows) {
  const Vec2 base_px = base_spot_px(optics, image_cols, image_rows);
  const Vec2 base_cpp = base_grating_cpp(sensor, slm);
  const PxPerCycle scale = px_per_cycle(optics, slm);
  std::vector<Vec2> spots;
  spots.reserve(lattice.subapertures.size());
  for (const Subaperture& s : lattice.subapertures) {
    spots.push_back(base_px + scale * (s.frequency_cpp - base_cpp));
  }
  return spots;
}

}  // namespace ovws
