#include "core/optics/flatness.hpp"

#include <cmath>
#include <vector>

#include "core/optics/circle_columns.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {

Vec2 cell_centre(int cells, int index) {
  return {(2.0 * (index % cells) + 1.0) / cells - 1.0,
          (2.0 * double(index / cells) + 1.0) / cells - 1.0};
}

float value_at(const Image<float>& map, Vec2 at) {
  const double x = 0.5 * ((at.x + 1.0) * map.width - 1.0);
  const double y = 0.5 * ((at.y + 1.0) * map.height - 1.0);
  double sum = 0.0, weights = 0.0;
  for (int row = int(std::floor(y)), r = 0; r < 2; ++r, ++row) {
    for (int column = int(std::floor(x)), c = 0; c < 2; ++c, ++column) {
      if (row < 0 || column < 0 || row >= map.height || column >= map.width) continue;
      if (std::isnan(map.at(column, row))) continue;
      const double weight = (1.0 - std::abs(x - column)) * (1.0 - std::abs(y - row));
      sum += weight * double(map.at(column, row));
      weights += weight;
    }
  }
  return weights > 0.0 ? float(sum / weights) : 0.0F;
}

std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              const Image<float>& fine, double pupil_diameter_px) {
  const SlmGeometry& slm = configured.slm;
  auto map = configured.flatness_waves
                 ? std::make_shared<Image<float>>(*configured.flatness_waves)
                 : std::make_shared<Image<float>>(slm.width_px, slm.height_px);
  const Vec2 centre{0.5 * (slm.width_px - 1), 0.5 * (slm.height_px - 1)};
  const WavefrontRows error(error_modes, centre, pupil_diameter_px);
  std::vector<double> waves(std::size_t(slm.width_px));
  for (int y = 0; y < slm.height_px; ++y) {
    const Columns pupil = columns_in_circle(centre, pupil_diameter_px, y, slm.width_px);
    const std::span<double> row(waves.data(), std::size_t(pupil.end - pupil.begin));
    error.waves(y, pupil.begin, row);
    for (int x = pupil.begin; x < pupil.end; ++x) {
      map->at(x, y) -= float(row[std::size_t(x - pupil.begin)]);
      if (fine.pixels.empty()) continue;
      map->at(x, y) -=
          value_at(fine, (2.0 / pupil_diameter_px) * (Vec2{double(x), double(y)} - centre));
    }
  }
  return map;
}

}  // namespace ovws
