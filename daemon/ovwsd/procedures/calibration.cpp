#include "daemon/ovwsd/procedures/measurements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "daemon/ovwsd/fitter/spots_model.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/procedures/pokes.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

constexpr double kMaxDrift = 0.05;  // lambda/d, drift of the spots from before to after all pokes
// Default poke amplitudes, waves RMS. Pixel intensities are linear in the amplitude over a smaller
// range than spot positions.
constexpr double kPositionPokeWaves = 0.15, kShapePokeWaves = 0.03;

Result<std::vector<int>> modes_to_poke(const CalibrationRun& run,
                                       const std::vector<int>& determined) {
  if (run.modes_j.empty()) return determined;
  for (const int j : run.modes_j) {
    if (std::find(determined.begin(), determined.end(), j) != determined.end()) continue;
    return fail(Errc::invalid, "modes",
                "this lattice does not determine j = " + std::to_string(j) + ", only j = 1 to " +
                    std::to_string(determined.empty() ? 0 : determined.back()));
  }
  std::vector<int> modes_j = run.modes_j;
  std::sort(modes_j.begin(), modes_j.end());
  return modes_j;
}

/// Refuses an incomplete matrix if `all` modes were requested. The reconstructor would attribute a
/// missing mode to other modes, so frames would be valid but wrong.
Result<void> check_complete(const InteractionMatrix& matrix, bool all) {
  if (!all || matrix.dropped.empty()) return {};
  std::string modes;
  for (const DroppedMode& mode : matrix.dropped) {
    modes += (modes.empty() ? "" : ", ") + std::to_string(mode.j);
  }
  const DroppedMode& first = matrix.dropped[0];
  return fail(Errc::refused, "modes",
              "spots were lost, and without them the modes j = " + modes +
                  " cannot be measured (j = " + std::to_string(first.j) + ": " + first.reason +
                  "): check that the light reaches the whole pupil, poke by fewer waves "
                  "(amplitude_waves), or request the other modes only (modes)");
}

/// Measurements of the pokes of all modes.
struct MeasuredPokes {
  PushPullRun places;             ///< pokes of modes that spot positions determine
  std::vector<PokedSpots> cells;  ///< pokes of the modes `cells_j`; empty: positions only
  std::vector<int> cells_j;
  SpotCells resting;
  std::vector<DroppedMode> dropped;
  std::vector<int> unsteady_j;
  bool any_lost = false;
};

/// Adds a poke to the shape pokes if it has pixels, and to the position pokes if spot positions
/// determine its mode.
void add(Poke poke, const ModeOperator& model, MeasuredPokes& measured) {
  const int j = poke.places.j;
  if (!poke.is_steady) measured.unsteady_j.push_back(j);
  if (poke.cells.plus.size() > 0) {
    measured.cells.push_back(std::move(poke.cells));
    measured.cells_j.push_back(j);
  }
  const auto at = std::find(model.modes_j.begin(), model.modes_j.end(), j);
  if (at == model.modes_j.end()) return;
  SpotMeans& before = measured.places.before;
  measured.any_lost = measured.any_lost || !lost_by(poke.places, before).empty();
  fill_lost(before, model.slopes.col(at - model.modes_j.begin()), poke.places);
  measured.places.modes.push_back(std::move(poke.places));
}

Result<MeasuredPokes> measure_all(Bench& bench, Pokes& pokes, const std::vector<int>& modes_j,
                                  double amplitude_waves, const ModeOperator& model) {
  MeasuredPokes measured;
  auto before = pokes.rest();
  if (!before) return fail(before.error());
  measured.places.before = std::move(before->places);
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    bench.report_progress(double(k + 1) / double(modes_j.size() + 2));
    auto poked = pokes.poke(modes_j[k], amplitude_waves, measured.places.before);
    if (!poked) return fail(poked.error());
    if (poked->poke) {
      add(std::move(*poked->poke), model, measured);
    } else {
      measured.dropped.push_back({modes_j[k], poked->reason});
    }
  }
  auto after = pokes.rest();
  if (!after) return fail(after.error());
  measured.places.after = std::move(after->places);
  if (pokes.meter().uses_images()) measured.resting = 0.5F * (before->cells + after->cells);
  return measured;
}

/// Spot shapes of the modes of the matrix, followed by the modes that only shapes determine. Null:
/// the spots were measured by positions.
std::shared_ptr<const MeasuredShapes> shapes_of(const SpotMeter& meter,
                                                const MeasuredPokes& measured,
                                                const std::vector<int>& matrix_j,
                                                const std::vector<int>& by_positions_j,
                                                const std::vector<Mode>& shown) {
  if (!meter.uses_images()) return nullptr;
  MeasuredShapes shapes{matrix_j, {}};
  for (const int j : measured.cells_j) {
    const bool is_position =
        std::find(by_positions_j.begin(), by_positions_j.end(), j) != by_positions_j.end();
    if (!is_position) shapes.modes_j.push_back(j);
  }
  std::vector<PokedSpots> cells;
  for (const int j : shapes.modes_j) {
    const auto at = std::find(measured.cells_j.begin(), measured.cells_j.end(), j);
    cells.push_back(measured.cells[std::size_t(at - measured.cells_j.begin())]);
    shapes.poke_waves.push_back(cells.back().amplitude_waves);
  }
  shapes.fixed = fixed_modes(shown, shapes.modes_j);
  shapes.spots = measured_spots(meter.windows(), meter.places_px(), measured.resting, cells);
  return std::make_shared<const MeasuredShapes>(std::move(shapes));
}

/// Emits a warning event if the calibration lacks spots or modes. It is usable, but aberration in a
/// missing mode appears as other modes.
void warn_of_dropped(Bench& bench, const InteractionMatrix& matrix) {
  std::vector<int> dropped_j;
  for (const DroppedMode& mode : matrix.dropped) dropped_j.push_back(mode.j);
  if (dropped_j.empty() && matrix.lost_spots.empty()) return;
  std::string text = "the calibration";
  if (!matrix.lost_spots.empty()) {
    text += fmt::format(" lacks spots {}", listed_spots(matrix.lost_spots));
  }
  if (!dropped_j.empty()) {
    text += fmt::format(
        "{} does not measure modes j = {} ({}): their aberration appears as other modes",
        matrix.lost_spots.empty() ? "" : " and", listed_spots(dropped_j), matrix.dropped[0].reason);
  }
  bench.warn("calibration", text,
             {{"lost_spots", matrix.lost_spots}, {"dropped_modes", dropped_j}});
}

void warn_of_unsteady(Bench& bench, const std::vector<int>& modes_j) {
  if (modes_j.empty()) return;
  bench.warn("calibration",
             fmt::format("the response to modes j = {} differed by more than 2 % each time they "
                         "were poked: let the bench settle, check slm.settle_ms by slm.settle, "
                         "and calibrate again with more frames",
                         listed_spots(modes_j)),
             {{"unsteady_modes", modes_j}});
}

}  // namespace

Result<MeasuredCalibration> measure_calibration(Bench& bench, const CalibrationRun& run) {
  const SlmGeometry& slm = bench.geometry();
  const SensorView view = bench.sensor();
  const SensorSnapshot& now = *view;
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const CameraSettings camera = bench.camera().settings;
  const bool by_images = now.tracking.tracker == TrackerKind::fit;
  ModeOperator model =
      slope_operator(*lattice, now.sensor, now.tracking, px_per_cycle(now.optics, slm));
  if (by_images) {
    auto made = displacement_operator(now.sensor, slm, now.optics, camera.roi,
                                      lit_pixels(camera.pixel_format, now.optics.wavelength_nm),
                                      model.modes_j);
    if (!made) return fail(made.error());
    model = std::move(*made);
  }
  const double spot_px = lambda_d_px(now.optics, slm, now.sensor);
  const auto modes_j =
      modes_to_poke(run, by_images ? with_shapes(now.tracking, model.modes_j) : model.modes_j);
  if (!modes_j) return fail(modes_j.error());
  auto meter = by_images ? SpotMeter::of_images(bench, run.frames) : SpotMeter::of_positions();
  if (!meter) return fail(meter.error());
  Pokes pokes(bench, std::move(*meter), run.frames, spot_px);
  const double amplitude_waves =
      run.amplitude_waves.value_or(by_images ? kShapePokeWaves : kPositionPokeWaves);
  auto measured = measure_all(bench, pokes, *modes_j, amplitude_waves, model);
  if (!measured) return fail(measured.error());
  auto matrix = interaction_matrix(measured->places, kMaxDrift * spot_px);
  if (!matrix) return fail(matrix.error());
  const bool any_lost = measured->any_lost || !matrix->lost_spots.empty();
  matrix->dropped.insert(matrix->dropped.begin(), measured->dropped.begin(),
                         measured->dropped.end());
  if (auto complete = check_complete(*matrix, any_lost && run.modes_j.empty()); !complete) {
    return fail(complete.error());
  }
  MeasuredCalibration calibration;
  calibration.amplitude_waves = amplitude_waves;
  calibration.frames = run.frames;
  calibration.t_taken_ns = utc_ns();
  calibration.comparison = compare(*matrix, model);
  calibration.unsteady_j = std::move(measured->unsteady_j);
  calibration.shapes = shapes_of(pokes.meter(), *measured, matrix->modes_j, model.modes_j,
                                 shown_modes(HologramKind::sensor, now.aberration, now.correction));
  calibration.matrix = std::move(*matrix);
  warn_of_dropped(bench, calibration.matrix);
  warn_of_unsteady(bench, calibration.unsteady_j);
  return calibration;
}

}  // namespace ovws
