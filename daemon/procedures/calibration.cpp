#include "daemon/procedures/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "daemon/mode_operators.hpp"

namespace ovws {
namespace {

constexpr double kMostDrift = 0.05;   // lambda/d, from the first picture to the last
constexpr int kMostHalvings = 2;      // of the amplitude
constexpr double kMostFilled = 0.25;  // of the spots, by both pictures of a mode
constexpr double kModelError = 0.2;   // of what the model says of a spot that was lost

std::vector<Mode> with_push(std::vector<Mode> shown, int j, double waves) {
  const auto at =
      std::find_if(shown.begin(), shown.end(), [j](const Mode& mode) { return mode.j == j; });
  if (at == shown.end()) {
    shown.push_back({j, waves});
  } else {
    at->waves += waves;
  }
  return shown;
}

/// A spot that is found in fewer than half of the frames is lost.
SpotMeans means_of(const ReferenceCollector::Average& average) {
  SpotMeans means{average.mean_px, average.standard_error_px};
  for (std::size_t i = 0; i < average.found.size(); ++i) {
    if (average.found[i] < 2 || 2 * average.found[i] < average.frames) {
      means.at_px[i] = {NAN, NAN};
    }
  }
  return means;
}

Result<SpotMeans> look(Bench& bench, const std::vector<Mode>& aberration, int frames) {
  if (auto shown = bench.show(aberration); !shown) return fail(shown.error());
  const auto average = bench.spots(frames);
  if (!average) return fail(average.error());
  return means_of(*average);
}

bool is_known(const SpotMeans& spots, std::size_t i) {
  return std::isfinite(spots.at_px[i].x) && std::isfinite(spots.at_px[i].y);
}

/// How many times as far as the model says the spots moved that both pictures of a mode show.
double factor_of(const PushPull& push, const Eigen::Ref<const Eigen::VectorXd>& model) {
  double both = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < push.plus.at_px.size(); ++i) {
    if (!is_known(push.plus, i) || !is_known(push.minus, i)) continue;
    const Vec2 moved = push.plus.at_px[i] - push.minus.at_px[i];
    const auto row = 2 * Eigen::Index(i);
    const double x = 2.0 * push.amplitude_waves * model[row];
    const double y = 2.0 * push.amplitude_waves * model[row + 1];
    both += moved.x * x + moved.y * y;
    squares += x * x + y * y;
  }
  return squares > 0.0 ? both / squares : 1.0;
}

/// A spot that one picture lost moved as far the other way as the other picture shows.
void mirror(const SpotMeans& seen, const SpotMeans& resting, std::size_t i, SpotMeans& lost) {
  const Vec2 &a = seen.standard_error_px[i], &b = resting.standard_error_px[i];
  lost.at_px[i] = 2.0 * resting.at_px[i] - seen.at_px[i];
  lost.standard_error_px[i] = {std::hypot(a.x, 2.0 * b.x), std::hypot(a.y, 2.0 * b.y)};
}

/// Puts in what the pictures of a mode lack of the resting spots: from the other picture, or, where
/// both lost the spot, from the model's column times what the other spots moved of theirs. Else the
/// spot would count for no mode. Nothing of the model if both lost too many.
void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& push) {
  for (const int spot : lost_by(push, resting)) {
    const auto i = std::size_t(spot);
    const bool up = is_known(push.plus, i), down = is_known(push.minus, i);
    if (up) mirror(push.plus, resting, i, push.minus);
    if (down) mirror(push.minus, resting, i, push.plus);
  }
  const std::vector<int> lost = lost_by(push, resting);
  if (double(lost.size()) > kMostFilled * double(resting.at_px.size())) return;
  const double factor = factor_of(push, model);
  for (const int spot : lost) {
    const auto i = std::size_t(spot);
    const auto row = 2 * Eigen::Index(i);
    const Vec2 moved = push.amplitude_waves * factor * Vec2{model[row], model[row + 1]};
    push.plus.at_px[i] = resting.at_px[i] + moved;
    push.minus.at_px[i] = resting.at_px[i] - moved;
    const double error_px = kModelError * norm(moved);
    push.plus.standard_error_px[i] = push.minus.standard_error_px[i] = {error_px, error_px};
  }
}

Result<std::vector<int>> modes_to_push(const CalibrationRun& run, const ModeOperator& model) {
  if (!run.modes_j) return model.modes_j;
  for (const int j : *run.modes_j) {
    const auto& told = model.modes_j;
    if (std::find(told.begin(), told.end(), j) != told.end()) continue;
    return fail(Errc::invalid, "modes",
                "this lattice does not tell j = " + std::to_string(j) + ": it tells j = 1 to " +
                    std::to_string(told.empty() ? 0 : told.back()));
  }
  return *run.modes_j;
}

struct Pushed {
  std::optional<PushPull> push;  ///< none: the SLM cannot show it
  std::string reason;
};

Result<Pushed> push_and_pull(Bench& bench, const std::vector<Mode>& shown, int j,
                             double amplitude_waves, int frames) {
  Pushed pushed{PushPull{j, amplitude_waves, {}, {}}, ""};
  for (const double sign : {1.0, -1.0}) {
    auto spots = look(bench, with_push(shown, j, sign * amplitude_waves), frames);
    if (!spots) {
      const Error& why = spots.error();
      if (why.code != Errc::invalid || why.field != "modes") return fail(why);
      return Pushed{std::nullopt, "the SLM cannot show it: " + why.reason};
    }
    (sign > 0.0 ? pushed.push->plus : pushed.push->minus) = std::move(*spots);
  }
  return pushed;
}

/// By less, if the SLM can show that, or if it keeps the spots: a strong push of a high mode may
/// lose those at the rim.
Result<Pushed> gentle_push(Bench& bench, const std::vector<Mode>& shown, int j,
                           const CalibrationRun& run, const SpotMeans& resting) {
  Result<Pushed> pushed = fail(Errc::refused, "", "");
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings) {
    pushed = push_and_pull(bench, shown, j, std::ldexp(run.amplitude_waves, -halvings), run.frames);
    if (!pushed || (pushed->push && lost_by(*pushed->push, resting).empty())) return pushed;
  }
  return pushed;
}

/// Without a mode what it holds is read as other modes: frames that are valid, and wrong. So if
/// spots were lost, and `all` modes were asked for, none may be missing.
Result<void> check_whole(const InteractionMatrix& matrix, bool all) {
  if (!all || matrix.dropped.empty()) return {};
  std::string modes;
  for (const DroppedMode& mode : matrix.dropped) {
    modes += (modes.empty() ? "" : ", ") + std::to_string(mode.j);
  }
  const DroppedMode& first = matrix.dropped[0];
  return fail(Errc::refused, "modes",
              "spots were lost, and without them the modes j = " + modes +
                  " cannot be measured (j = " + std::to_string(first.j) + ": " + first.reason +
                  "): see that the light reaches the whole pupil, push by fewer waves "
                  "(amplitude_waves), or ask for the others alone (modes)");
}

Result<InteractionMatrix> measure_matrix(Bench& bench, const std::vector<int>& modes_j,
                                         const CalibrationRun& run, const ModeOperator& model,
                                         double most_drift_px) {
  const std::vector<Mode> shown = bench.sensor().aberration;
  PushPullRun pictures;
  std::vector<DroppedMode> dropped;
  bool any_lost = false;
  auto before = look(bench, shown, run.frames);
  if (!before) return fail(before.error());
  pictures.before = std::move(*before);
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    bench.tell(double(k + 1) / double(modes_j.size() + 2));
    auto pushed = gentle_push(bench, shown, modes_j[k], run, pictures.before);
    if (!pushed) return fail(pushed.error());
    if (pushed->push) {
      const auto at = std::find(model.modes_j.begin(), model.modes_j.end(), modes_j[k]);
      any_lost = any_lost || !lost_by(*pushed->push, pictures.before).empty();
      fill_lost(pictures.before, model.slopes.col(at - model.modes_j.begin()), *pushed->push);
      pictures.modes.push_back(std::move(*pushed->push));
    }
    if (!pushed->push) dropped.push_back({modes_j[k], pushed->reason});
  }
  auto after = look(bench, shown, run.frames);
  if (!after) return fail(after.error());
  pictures.after = std::move(*after);
  auto matrix = interaction_matrix(pictures, most_drift_px);
  if (!matrix) return matrix;
  any_lost = any_lost || !matrix->lost_spots.empty();
  matrix->dropped.insert(matrix->dropped.begin(), dropped.begin(), dropped.end());
  if (auto whole = check_whole(*matrix, any_lost && !run.modes_j); !whole) {
    return fail(whole.error());
  }
  return matrix;
}

}  // namespace

Result<MeasuredCalibration> measure_calibration(Bench& bench, const SlmGeometry& slm,
                                                const CalibrationRun& run) {
  const SensorSnapshot now = bench.sensor();
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const ModeOperator model =
      slope_operator(*lattice, now.sensor, now.tracking, px_per_cycle(now.optics, slm));
  const auto modes_j = modes_to_push(run, model);
  if (!modes_j) return fail(modes_j.error());
  auto matrix = measure_matrix(bench, *modes_j, run, model,
                               kMostDrift * lambda_d_px(now.optics, slm, now.sensor));
  if (!matrix) return fail(matrix.error());
  MeasuredCalibration measured;
  measured.amplitude_waves = run.amplitude_waves;
  measured.frames = run.frames;
  measured.t_taken_ns = utc_ns();
  measured.comparison = compare(*matrix, model);
  measured.matrix = std::move(*matrix);
  return measured;
}

}  // namespace ovws
