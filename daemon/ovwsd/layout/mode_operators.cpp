#include "daemon/ovwsd/layout/mode_operators.hpp"

#include <algorithm>
#include <numeric>

#include "core/spots/measured_spots.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/spots/spot_templates.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr double kMaxCondition = 1000.0;
/// Light that does not fill the pupil leaves part of it unmeasured. A mode that differs from others
/// mainly there would have the errors of all slopes, much enlarged. A pupil full of light has 25.
constexpr double kMaxLensletCondition = 40.0;

}  // namespace

std::vector<int> reconstructed_modes(const SensorConfig& sensor) {
  const int modes = std::min(optimal_mode_count(sensor.subapertures_across), kMaxZernikeIndex);
  std::vector<int> modes_j(static_cast<std::size_t>(modes));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  return modes_j;
}

ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map) {
  return slope_operator(lattice, sensor, tilt_radii(lattice, tracking), map);
}

ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            std::span<const double> tilt_radii, const PxPerCycle& map) {
  ModeOperator made{OperatorKind::slopes, reconstructed_modes(sensor), {}};
  made.slopes = slope_matrix(lattice, sensor, made.modes_j, tilt_radii, map);
  const double most = sensor.lenslets.empty() ? kMaxCondition : kMaxLensletCondition;
  made.modes_j.resize(std::size_t(determined_modes(made.slopes, most)));
  made.slopes.conservativeResize(Eigen::NoChange, Eigen::Index(made.modes_j.size()));
  return made;
}

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
