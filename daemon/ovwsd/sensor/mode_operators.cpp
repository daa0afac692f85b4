#include "daemon/ovwsd/sensor/mode_operators.hpp"

#include "core/spots/measured_spots.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/spots/spot_templates.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {

std::vector<int> with_shapes(const TrackingSettings& tracking, std::vector<int> modes_j) {
  const bool by_shapes = tracking.tracker == TrackerKind::fit;
  const int last = by_shapes ? tracking.mode_count.value_or(0) : 0;
  for (int j = modes_j.empty() ? 1 : modes_j.back() + 1; j <= last; ++j) modes_j.push_back(j);
  return modes_j;
}

Result<ModeOperator> displacement_operator(const SensorConfig& sensor, const SlmGeometry& slm,
                                           const OpticsConfig& optics, const Roi& roi,
                                           const LitPixels& lit, std::vector<int> modes_j) {
  auto renderer =
      SpotRenderer::make(sensor, slm, optics, roi.width, roi.height, modes_j, {.lit = lit});
  if (!renderer) return fail(renderer.error());
  auto rendered = renderer->render(std::vector<double>(modes_j.size()));
  for (RenderedSpot& spot : rendered) spot.per_px = change_by_shift(spot.light, spot.window);
  const std::vector<CellLevel> levels(rendered.size(), CellLevel{1.0});
  const auto templates = make_templates(rendered, levels, PixelNoise{}, 1);
  ModeOperator made{OperatorKind::slopes, std::move(modes_j), {}};
  made.slopes.setZero(2 * Eigen::Index(rendered.size()), Eigen::Index(made.modes_j.size()));
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    if (templates[i].estimates() == 0) continue;
    const auto rows = templates[i].rows.middleRows(SpotTemplates::kX, 2);
    made.slopes.middleRows(2 * Eigen::Index(i), 2) =
        (rows.leftCols(rendered[i].light.size()) * rendered[i].per_wave).cast<double>();
  }
  return made;
}

}  // namespace ovws
