#include "drivers/twin/ideal_hologram.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/optics/circle_columns.hpp"
#include "core/optics/lattice.hpp"

namespace ovws::twin {
namespace {

/// A circular aperture with a grating and a vortex about its centre.
struct Piece {
  Vec2 centre_px;  ///< relative to the pupil's centre, SLM pixels
  double diameter_px = 0.0;
  Vec2 frequency_cpp;
  int charge = 0;
  std::optional<int> subaperture = std::nullopt;  ///< none: the base grating alone
};

std::vector<Piece> pieces(const Config& config, Pattern pattern) {
  const SensorConfig& sensor = config.sensor;
  const SlmGeometry& slm = config.slm.geometry;
  if (pattern == Pattern::grating) {
    return {{{},
             sensor.pupil_diameter_px,
             {sensor.grooves[0] / slm.width_px, sensor.grooves[1] / slm.height_px}}};
  }
  const auto lattice = make_lattice(sensor, slm);
  std::vector<Piece> found;
  for (const Subaperture& s : lattice->subapertures) {
    found.push_back(
        {s.centre_px, lattice->diameter_px, s.frequency_cpp, s.charge, int(found.size())});
  }
  return found;
}

}  // namespace

Image<std::complex<float>> ideal_hologram(const Config& config, Pattern pattern) {
  const SlmGeometry& slm = config.slm.geometry;
  const Masks& masks = config.sensor.masks;
  const Vec2 middle{(slm.width_px - 1) / 2.0, (slm.height_px - 1) / 2.0};
  Image<std::complex<float>> ideal(slm.width_px, slm.height_px);
  for (const Piece& piece : pieces(config, pattern)) {
    const Vec2 centre = middle + piece.centre_px;
    for (int y = 0; y < slm.height_px; ++y) {
      const Columns inside = columns_in_circle(centre, piece.diameter_px, y, slm.width_px);
      for (int x = inside.begin; x < inside.end; ++x) {
        const Vec2 at = (2.0 / piece.diameter_px) * Vec2{x - centre.x, y - centre.y};
        const double waves = piece.frequency_cpp.x * (x - middle.x) +
                             piece.frequency_cpp.y * (y - middle.y) +
                             (piece.subaperture ? mask_waves(masks, *piece.subaperture, at) : 0.0);
        const double angle = 2.0 * std::numbers::pi * (waves - std::floor(waves)) +
                             piece.charge * std::atan2(y - centre.y, x - centre.x);
        ideal.at(x, y) = {float(std::cos(angle)), float(std::sin(angle))};
      }
    }
  }
  return ideal;
}

}  // namespace ovws::twin
