#include "core/optics/flatness.hpp"

#include <vector>

#include "core/optics/circle_columns.hpp"
#include "core/optics/wavefront_rows.hpp"

namespace ovws {

std::shared_ptr<const Image<float>> flattened(const HologramConfig& configured,
                                              std::span<const Mode> error_modes,
                                              double pupil_diameter_px) {
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
    }
  }
  return map;
}

}  // namespace ovws
