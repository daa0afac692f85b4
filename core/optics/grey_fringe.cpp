#include "core/optics/grey_fringe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics/circle_columns.hpp"

namespace ovws {
namespace {

constexpr double kPupilShare = 0.5;  // maximum distance of the patches, in pupil diameters
constexpr double kMinFringePx = 4.0;
constexpr double kReach = 1.8;  // radius, lambda / patch diameter; the first dark ring is at 1.22

/// Draws one patch with a grating. `side`: -1 left, 1 right. `level_of` maps the position in the
/// grating's period, 0 .. 1, to a grey level.
template <class LevelOf>
void draw_patch(const FringePatches& patches, const SensorConfig& sensor, double side,
                const LevelOf& level_of, Image<std::uint8_t>& grey) {
  const Vec2 frequency_cpp{sensor.grooves[0] / grey.width, sensor.grooves[1] / grey.height};
  const Vec2 pupil{0.5 * (grey.width - 1), 0.5 * (grey.height - 1)};
  const Vec2 centre = pupil + Vec2{0.5 * side * patches.distance_px, 0.0};
  for (int y = 0; y < grey.height; ++y) {
    const Columns columns = columns_in_circle(centre, patches.diameter_px, y, grey.width);
    for (int x = columns.begin; x < columns.end; ++x) {
      const double turns = frequency_cpp.x * (x - centre.x) + frequency_cpp.y * (y - centre.y);
      grey.at(x, y) = level_of(turns - std::floor(turns));
    }
  }
}

auto binary(int level) {
  return [level](double part) { return part < 0.5 ? std::uint8_t(level) : std::uint8_t(0); };
}

void clear_image(const SlmGeometry& slm, Image<std::uint8_t>& grey) {
  grey.width = slm.width_px;
  grey.height = slm.height_px;
  grey.pixels.assign(std::size_t(grey.width) * std::size_t(grey.height), 0);
}

}  // namespace

FringePatches fringe_patches(const SensorConfig& sensor, const PxPerCycle& map, double share,
                             const LitPixels& lit) {
  FringePatches patches;
  const int apart = lit.diagonal ? 1 : lit.plane.step;
  patches.distance_px =
      std::min(kPupilShare * sensor.pupil_diameter_px, map.scale() / (kMinFringePx * apart));
  patches.diameter_px = std::min(share * sensor.pupil_diameter_px / sensor.subapertures_across,
                                 0.5 * patches.distance_px);
  return patches;
}

void draw_fringe_patches(const FringePatches& patches, const SensorConfig& sensor,
                         const SlmGeometry& slm, int grey_left, int grey_right,
                         Image<std::uint8_t>& grey) {
  clear_image(slm, grey);
  draw_patch(patches, sensor, -1.0, binary(grey_left), grey);
  draw_patch(patches, sensor, 1.0, binary(grey_right), grey);
}

void draw_blazed_patch(const FringePatches& patches, const SensorConfig& sensor,
                       const SlmGeometry& slm, const PhaseLut& lut, Image<std::uint8_t>& grey) {
  clear_image(slm, grey);
  const auto blazed = [&lut](double part) {
    return lut[std::min(std::size_t(256.0 * part), std::size_t(255))];
  };
  draw_patch(patches, sensor, -1.0, blazed, grey);
}

FringeReading read_fringe(const Image<float>& light, const FringePatches& patches, Vec2 base_px,
                          const PxPerCycle& map) {
  FringeReading reading;
  const double reach_px = kReach * map.scale() / patches.diameter_px;
  const double det = map.determinant();
  const auto first = [reach_px](double at) { return std::max(0, int(std::ceil(at - reach_px))); };
  const auto end = [reach_px](double at, int size) {
    return std::min(size, int(std::floor(at + reach_px)) + 1);
  };
  for (int y = first(base_px.y); y < end(base_px.y, light.height); ++y) {
    for (int x = first(base_px.x); x < end(base_px.x, light.width); ++x) {
      const Vec2 from{x - base_px.x, y - base_px.y};
      const double r = norm(from) / reach_px;
      if (r >= 1.0) continue;
      const double value = light.at(x, y);
      if (std::isnan(value)) {
        reading.saturated = true;
        continue;
      }
      reading.brightest_dn = std::max(reading.brightest_dn, value);
      // Hann window: it has no sharp edge, so other fringe frequencies leak less into the beat.
      const double weight = std::pow(std::cos(0.5 * std::numbers::pi * r), 2);
      const double cycles_x = (map.yy * from.x - map.xy * from.y) / det;  // cycles per SLM pixel
      const double turns = cycles_x * patches.distance_px;
      // The minus sign makes the phase of `beat` the left patch's phase minus the right patch's.
      reading.beat += std::polar(weight * value, -2.0 * std::numbers::pi * turns);
    }
  }
  return reading;
}

PxPerCycle find_fringe_rotation(const Image<float>& light, const FringePatches& patches,
                                Vec2 base_px, double scale) {
  PxPerCycle best = scale;
  double most = -1.0;
  for (int degrees = 0; degrees < 180; ++degrees) {
    const double c = scale * std::cos(degrees * std::numbers::pi / 180.0);
    const double s = scale * std::sin(degrees * std::numbers::pi / 180.0);
    const PxPerCycle map{c, -s, s, c};
    const double beat = std::abs(read_fringe(light, patches, base_px, map).beat);
    if (beat <= most) continue;
    most = beat;
    best = map;
  }
  return best;
}

}  // namespace ovws
