#include "core/spots/measured_spots.hpp"

#include <algorithm>

namespace ovws {
namespace {

constexpr float kMinLight = 0.03F;  // fraction of the brightest spot; a dimmer spot is stray light

bool is_known(const SpotCells& cells, Eigen::Index spot) {
  return cells.col(spot).allFinite();
}

}  // namespace

bool MeasuredShapes::are_inside(int cols, int rows) const {
  return std::all_of(spots.begin(), spots.end(), [&](const RenderedSpot& spot) {
    const PixelBox box = spot.window.pixels();
    return box.x >= 0 && box.y >= 0 && box.x + box.width <= cols && box.y + box.height <= rows;
  });
}

/// Central differences of binned pixels, of the same colour. At the edge, uses the difference of
/// the next inner pixel.
Eigen::MatrixXf change_by_shift(const Eigen::VectorXf& light, const SpotWindow& window) {
  const auto side = Eigen::Index(window.side), step = Eigen::Index(window.colour_step());
  const float by = 1.0F / float(2 * step * window.pitch());
  const auto inner = [&](Eigen::Index k) {
    return k < step ? k + step : k >= side - step ? k - step : k;
  };
  Eigen::MatrixXf change(light.size(), 2);
  for (Eigen::Index c = 0; c < light.size(); ++c) {
    const Eigen::Index row = c / side, column = c % side;
    const Eigen::Index x = row * side + inner(column);
    const Eigen::Index y = inner(row) * side + column;
    change(c, 0) = by * (light(x - step) - light(x + step));
    change(c, 1) = by * (light(y - step * side) - light(y + step * side));
  }
  return change;
}

SpotCells cells_in(const Image<float>& mean_dn, std::span<const SpotWindow> windows) {
  SpotCells cells = SpotCells::Zero(windows.front().cells(), Eigen::Index(windows.size()));
  for (std::size_t i = 0; i < windows.size(); ++i) {
    each_pixel(windows[i], [&](Eigen::Index cell, int x, int y) {
      if (windows[i].lit.has(x, y)) cells(cell, Eigen::Index(i)) += mean_dn.at(x, y);
    });
  }
  return cells;
}

std::vector<RenderedSpot> measured_spots(std::span<const SpotWindow> windows,
                                         std::span<const Vec2> places_px, const SpotCells& resting,
                                         std::span<const PokedSpots> pokes) {
  std::vector<RenderedSpot> spots(windows.size());
  float brightest = 0.0F;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const auto column = Eigen::Index(i);
    RenderedSpot& spot = spots[i];
    spot.window = windows[i];
    spot.place_px = places_px[i];
    spot.light.setZero(resting.rows());
    spot.per_wave.setZero(resting.rows(), Eigen::Index(pokes.size()));
    const bool known = is_known(resting, column) &&
                       std::all_of(pokes.begin(), pokes.end(), [&](const PokedSpots& poke) {
                         return is_known(poke.plus, column) && is_known(poke.minus, column);
                       });
    if (known && is_inside(spot)) {
      spot.light = resting.col(column).array() - dark_level(resting.col(column), spot.window);
    }
    for (std::size_t k = 0; known && k < pokes.size(); ++k) {
      spot.per_wave.col(Eigen::Index(k)) =
          (pokes[k].plus.col(column) - pokes[k].minus.col(column)) /
          float(2.0 * pokes[k].amplitude_waves);
    }
    brightest = std::max(brightest, spot.light.maxCoeff());
  }
  for (RenderedSpot& spot : spots) {
    if (!(spot.light.maxCoeff() > kMinLight * brightest)) {
      spot.light.setZero();
      spot.per_wave.setZero();
    }
    if (brightest > 0.0F) spot.light /= brightest, spot.per_wave /= brightest;
    spot.per_px = change_by_shift(spot.light, spot.window);
    if (pokes.empty()) spot.per_wave = spot.per_px;
  }
  return spots;
}

}  // namespace ovws
