#include "daemon/ovwsd/sensor/mode_operators.hpp"

#include <algorithm>
#include <new>

#include "core/optics/sensor_field.hpp"
#include "core/port/clock.hpp"
#include "core/spots/measured_spots.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/spots/spot_templates.hpp"
#include "core/wavefront/diffractive_matrix.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"

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

OperatorKey operator_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                         const OpticsConfig& optics, const Roi& roi) {
  return {sensor, position_tracking(tracking), optics, roi.width, roi.height};
}

Result<ModeOperator> diffractive_operator(const OperatorKey& key, const SlmGeometry& slm,
                                          double limit_s) {
  try {
    const auto lattice = make_lattice(key.sensor, slm);
    if (!lattice) return fail(lattice.error());
    auto field = SensorField::make(key.sensor, slm, key.optics, key.cols, key.rows);
    if (!field) return fail(field.error());
    const SpotModel spots{key.sensor.charge, lambda_d_px(key.optics, slm, key.sensor)};
    const auto tracker = make_tracker(key.tracking, spots);
    if (!tracker) return fail(tracker.error());
    const auto kinds = SpotKinds::make(key.tracking, spots, charges_of(*lattice));
    if (!kinds) return fail(kinds.error());
    const auto tracker_of = [&](int i) -> const SpotTracker& {
      return *kinds ? (*kinds)->tracker_of(i) : **tracker;
    };
    return diffractive_operator(
        *field, tracker_of,
        slope_operator(*lattice, key.sensor, key.tracking, px_per_cycle(key.optics, slm)),
        model_spots_px(*lattice, key.sensor, slm, key.optics, key.cols, key.rows), limit_s);
  } catch (const std::bad_alloc&) {
    return fail(
        Errc::unavailable, "tracking",
        "there is not enough memory for a model of this SLM and this image: reduce camera.roi");
  }
}

LastOperators::Made LastOperators::of(const OperatorKey& key, const SlmGeometry& slm) {
  const auto known = std::find_if(last_.begin(), last_.end(),
                                  [&](const Entry& entry) { return entry.key == key; });
  if (known != last_.end()) {
    const bool may_succeed = !*known->made && known->made->error().code == Errc::unavailable &&
                             monotonic_ns() > known->t_made_ns + kRetryNs;
    if (!may_succeed) return known->made;
    last_.erase(known);
  }
  auto made = std::make_shared<const Result<ModeOperator>>(diffractive_operator(key, slm, kLimitS));
  last_.push_front({key, std::move(made), monotonic_ns()});
  if (last_.size() > kCapacity) last_.pop_back();
  return last_.front().made;
}

}  // namespace ovws
