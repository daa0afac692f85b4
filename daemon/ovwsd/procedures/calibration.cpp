#include "daemon/ovwsd/procedures/calibration.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/lost_pokes.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws {
namespace {

constexpr double kMaxDrift = 0.05;    // lambda/d, from the first average without a poke to the last
constexpr double kMaxStep = 0.01;     // lambda/d, from a poke to its repetition, beyond noise
constexpr double kNoiseFactor = 4.0;  // standard errors that count as noise
constexpr int kMaxTries = 4;          // of a poke while the bench moves
constexpr int kMinFrames = 2;
constexpr int kMaxHalvings = 2;  // of the amplitude

std::vector<Mode> with_poke(std::vector<Mode> shown, int j, double waves) {
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
SpotMeans means_of(const SpotAverage& average) {
  SpotMeans means{average.mean_px, average.standard_error_px};
  for (std::size_t i = 0; i < average.found.size(); ++i) {
    if (average.found[i] < 2 || 2 * average.found[i] < average.frames) {
      means.at_px[i] = {NAN, NAN};
    }
  }
  return means;
}

Result<SpotMeans> measure_spots(Bench& bench, const std::vector<Mode>& aberration, int frames) {
  if (auto shown = bench.show(aberration); !shown) return fail(shown.error());
  const auto average = bench.spots(frames);
  if (!average) return fail(average.error());
  return means_of(*average);
}

Result<std::vector<int>> modes_to_poke(const CalibrationRun& run, const ModeOperator& model) {
  if (run.modes_j.empty()) return model.modes_j;
  for (const int j : run.modes_j) {
    const auto& determined = model.modes_j;
    if (std::find(determined.begin(), determined.end(), j) != determined.end()) continue;
    return fail(Errc::invalid, "modes",
                "this lattice does not determine j = " + std::to_string(j) + ", only j = 1 to " +
                    std::to_string(determined.empty() ? 0 : determined.back()));
  }
  std::vector<int> modes_j = run.modes_j;
  std::sort(modes_j.begin(), modes_j.end());
  return modes_j;
}

struct Poked {
  std::optional<PushPull> push_pull;  ///< none: the SLM cannot show it
  std::string reason;
};

/// Which modes are shown, and how each poke is measured.
struct Pokes {
  std::vector<Mode> shown;
  int frames = 0;  ///< of each of the two measurements
  double max_step_px = 0.0;
};

Result<PushPull> push_and_pull_once(Bench& bench, const Pokes& pokes, int j,
                                    double amplitude_waves) {
  PushPull poked{j, amplitude_waves, {}, {}};
  for (const double sign : {1.0, -1.0}) {
    auto spots =
        measure_spots(bench, with_poke(pokes.shown, j, sign * amplitude_waves), pokes.frames);
    if (!spots) return fail(spots.error());
    (sign > 0.0 ? poked.plus : poked.minus) = std::move(*spots);
  }
  return poked;
}

/// How far the bench moved between two measurements of the same poke, px RMS beyond noise.
double step_px(const PushPull& first, const PushPull& second) {
  const SpotDrift plus = drift_between(first.plus, second.plus);
  const SpotDrift minus = drift_between(first.minus, second.minus);
  return std::max(plus.rms_px - kNoiseFactor * plus.noise_px,
                  minus.rms_px - kNoiseFactor * minus.noise_px);
}

/// Measures + and - twice: a bench that moved in between would add its movement to the column.
/// Errc::refused: two measurements in a row never agreed.
Result<PushPull> push_and_pull(Bench& bench, const Pokes& pokes, int j, double amplitude_waves) {
  auto last = push_and_pull_once(bench, pokes, j, amplitude_waves);
  double step = 0.0;
  for (int tries = 0; last && tries < kMaxTries; ++tries) {
    auto next = push_and_pull_once(bench, pokes, j, amplitude_waves);
    if (!next) return next;
    step = step_px(*last, *next);
    if (step <= pokes.max_step_px) {
      return PushPull{j, amplitude_waves, mean_of_both(last->plus, next->plus),
                      mean_of_both(last->minus, next->minus)};
    }
    last = std::move(next);
  }
  if (!last) return last;
  return fail(
      Errc::refused, "",
      fmt::format("the bench moves: the spots of mode j = {} moved by {:.2f} px RMS from one "
                  "measurement to the next, {} times in a row (limit {:.2f} px): let it "
                  "settle, and measure again, or average more frames (frames)",
                  j, step, kMaxTries, pokes.max_step_px));
}

Result<Poked> poke_mode(Bench& bench, const Pokes& pokes, int j, double amplitude_waves) {
  auto push_pull = push_and_pull(bench, pokes, j, amplitude_waves);
  if (push_pull) return Poked{std::move(*push_pull), ""};
  const Error& why = push_pull.error();
  if (why.code != Errc::invalid || why.field != "modes") return fail(why);
  return Poked{std::nullopt, "the SLM cannot show it: " + why.reason};
}

/// Pokes a mode, and halves the amplitude up to kMaxHalvings times if the SLM cannot show it or
/// spots are lost: a strong poke of a high mode may lose spots at the rim.
Result<Poked> poke_gently(Bench& bench, const Pokes& pokes, int j, double amplitude_waves,
                          const SpotMeans& resting) {
  Result<Poked> poked = fail(Errc::refused, "", "");
  for (int halvings = 0; halvings <= kMaxHalvings; ++halvings) {
    poked = poke_mode(bench, pokes, j, std::ldexp(amplitude_waves, -halvings));
    if (!poked || (poked->push_pull && lost_by(*poked->push_pull, resting).empty())) return poked;
  }
  return poked;
}

/// Refuses an incomplete matrix if `all` modes were requested. A missing mode would be read as
/// other modes, so frames would be valid but wrong.
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

Result<InteractionMatrix> measure_matrix(Bench& bench, const std::vector<int>& modes_j,
                                         const CalibrationRun& run, const ModeOperator& model,
                                         double spot_px) {
  const Pokes pokes{bench.sensor()->aberration, std::max(kMinFrames, (run.frames + 1) / 2),
                    kMaxStep * spot_px};
  PushPullRun run_data;
  std::vector<DroppedMode> dropped;
  bool any_lost = false;
  auto before = measure_spots(bench, pokes.shown, run.frames);
  if (!before) return fail(before.error());
  run_data.before = std::move(*before);
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    bench.report_progress(double(k + 1) / double(modes_j.size() + 2));
    auto poked = poke_gently(bench, pokes, modes_j[k], run.amplitude_waves, run_data.before);
    if (!poked) return fail(poked.error());
    if (poked->push_pull) {
      const auto at = std::find(model.modes_j.begin(), model.modes_j.end(), modes_j[k]);
      any_lost = any_lost || !lost_by(*poked->push_pull, run_data.before).empty();
      fill_lost(run_data.before, model.slopes.col(at - model.modes_j.begin()), *poked->push_pull);
      run_data.modes.push_back(std::move(*poked->push_pull));
    }
    if (!poked->push_pull) dropped.push_back({modes_j[k], poked->reason});
  }
  auto after = measure_spots(bench, pokes.shown, run.frames);
  if (!after) return fail(after.error());
  run_data.after = std::move(*after);
  auto matrix = interaction_matrix(run_data, kMaxDrift * spot_px);
  if (!matrix) return matrix;
  any_lost = any_lost || !matrix->lost_spots.empty();
  matrix->dropped.insert(matrix->dropped.begin(), dropped.begin(), dropped.end());
  if (auto complete = check_complete(*matrix, any_lost && run.modes_j.empty()); !complete) {
    return fail(complete.error());
  }
  return matrix;
}

}  // namespace

Result<MeasuredCalibration> measure_calibration(Bench& bench, const SlmGeometry& slm,
                                                const CalibrationRun& run) {
  const SensorView view = bench.sensor();
  const SensorSnapshot& now = *view;
  if (now.modes_j.size() > now.position_modes_j.size()) {
    return fail(Errc::refused, "mode_count",
                fmt::format("a calibration measures positions, which tell {} modes and not {}: "
                            "call sensor.set with \"mode_count\": null first",
                            now.position_modes_j.size(), now.modes_j.size()));
  }
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const ModeOperator model =
      slope_operator(*lattice, now.sensor, now.tracking, px_per_cycle(now.optics, slm));
  const auto modes_j = modes_to_poke(run, model);
  if (!modes_j) return fail(modes_j.error());
  auto matrix =
      measure_matrix(bench, *modes_j, run, model, lambda_d_px(now.optics, slm, now.sensor));
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
