#include "daemon/procedures/flatness.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/diffractive_matrix.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/mode_operators.hpp"

namespace ovws {
namespace {

constexpr int kMostIterations = 8;
constexpr double kEnough = 3.0;           // times the noise of what is left
constexpr double kLeastResidual = 0.001;  // waves RMS: less is not looked for
constexpr double kMostResidual = 0.01;    // more is no result
constexpr double kMostUnexplained = 0.1;  // lambda/d RMS that no mode explains: a degree of turn
constexpr int kFirstMode = 3;             // tilts are no error of the SLM

/// Where the tracker finds the spots of a flat sensor before this camera. The model's camera is
/// straight: what neighbours do to a spot is turned as this one is.
Result<std::vector<Vec2>> flat_spots(const SensorSnapshot& now, const SlmGeometry& slm, int cols,
                                     int rows) {
  const PxPerCycle map = px_per_cycle(now.optics, slm);
  OpticsConfig straight = now.optics;
  straight.registered = PxPerCycle(map.scale());
  straight.centre_px.reset();
  auto model = SensorModel::make(now.sensor, slm, straight, cols, rows);
  if (!model) return fail(model.error());
  TrackingSettings tracking = now.tracking;
  tracking.templates = TemplateKind::model;
  const auto tracker = make_tracker(tracking, {now.sensor.charge, model->lambda_d_px()});
  if (!tracker) return fail(tracker.error());
  const auto fixes = model_fixes(*model, now.sensor, **tracker, {});
  if (!fixes) return fail(fixes.error());
  auto spots = model_spots_px(model->lattice(), now.sensor, slm, now.optics, cols, rows);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 at{(*fixes)[i].x, (*fixes)[i].y};
    const Vec2 by_neighbours = at - model->spots_px()[i];
    spots[i] = spots[i] + map * ((1.0 / map.scale()) * by_neighbours);
  }
  return spots;
}

struct Look {
  std::vector<double> waves;  ///< of every mode that the lattice tells
  std::vector<double> error;  ///< standard errors
  double fit_residual_px = 0.0;
};

/// Modes of j >= kFirstMode: root sum square.
double rms(const std::vector<int>& modes_j, const std::vector<double>& waves) {
  double sum = 0.0;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (modes_j[k] >= kFirstMode) sum += waves[k] * waves[k];
  }
  return std::sqrt(sum);
}

class FlatnessBench {
 public:
  FlatnessBench(Bench& bench, ModeOperator model, std::vector<Vec2> flat_px, int frames)
      : bench_(bench),
        model_(std::move(model)),
        reconstructor_(model_.slopes, model_.modes_j, std::move(flat_px)),
        frames_(frames) {}

  const std::vector<int>& modes_j() const { return model_.modes_j; }
  /// With the opposite of `error` shown.
  Result<Look> look(const std::vector<Mode>& error);

 private:
  const Eigen::MatrixXd& inverse_of(const std::vector<bool>& used);

  Bench& bench_;
  ModeOperator model_;
  Reconstructor reconstructor_;
  int frames_;
  std::vector<bool> used_;  ///< spots of `inverse_`
  Eigen::MatrixXd inverse_;
};

/// Of the slopes of these spots; it costs seconds on a fine lattice, and they seldom change.
const Eigen::MatrixXd& FlatnessBench::inverse_of(const std::vector<bool>& used) {
  if (used == used_) return inverse_;
  Eigen::MatrixXd slopes = model_.slopes;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) slopes.middleRows(Eigen::Index(2 * i), 2).setZero();
  }
  used_ = used;
  return inverse_ = slopes.completeOrthogonalDecomposition().pseudoInverse();
}

Result<Look> FlatnessBench::look(const std::vector<Mode>& error) {
  std::vector<Mode> opposite = error;
  for (Mode& mode : opposite) mode.waves = -mode.waves;
  if (auto shown = bench_.show(opposite); !shown) return fail(shown.error());
  const auto average = bench_.spots(frames_);
  if (!average) return fail(average.error());
  std::vector<SpotFix> spots(average->mean_px.size());
  std::vector<bool> used(spots.size());
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(model_.slopes.rows());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (average->found[i] < 2 || 2 * average->found[i] < average->frames) continue;
    used[i] = true;
    spots[i].x = float(average->mean_px[i].x);
    spots[i].y = float(average->mean_px[i].y);
    noise[Eigen::Index(2 * i)] = average->standard_error_px[i].x;
    noise[Eigen::Index(2 * i + 1)] = average->standard_error_px[i].y;
  }
  auto scratch = reconstructor_.make_scratch();
  std::vector<float> waves(model_.modes_j.size());
  const Reconstruction found = reconstructor_.solve(spots, scratch, waves);
  if (!found.determined) {
    return fail(Errc::refused, "",
                "too few spots are found to tell the modes: see that all of them are in the region "
                "of interest, and the exposure");
  }
  const Eigen::VectorXd errors = (inverse_of(used) * noise.asDiagonal()).rowwise().norm();
  return Look{{waves.begin(), waves.end()}, {errors.begin(), errors.end()}, found.fit_residual_px};
}

std::vector<Mode> sum(std::vector<Mode> modes, const std::vector<int>& modes_j,
                      const std::vector<double>& waves) {
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (modes_j[k] < kFirstMode) continue;
    const auto same = std::find_if(modes.begin(), modes.end(),
                                   [&](const Mode& mode) { return mode.j == modes_j[k]; });
    if (same == modes.end()) {
      modes.push_back({modes_j[k], waves[k]});
    } else {
      same->waves += waves[k];
    }
  }
  return modes;
}

/// And what was in force before.
std::vector<Mode> sum(std::vector<Mode> modes, const std::vector<Mode>& before) {
  for (const Mode& mode : before) modes = sum(std::move(modes), {mode.j}, {mode.waves});
  return modes;
}

/// Of the last look, with all of it shown; of a mode that this lattice does not tell as before.
std::vector<double> errors_of(const std::vector<Mode>& modes, const std::vector<int>& modes_j,
                              const Look& look, const MeasuredFlatness* before) {
  std::vector<double> errors;
  for (const Mode& mode : modes) {
    const auto at = std::find(modes_j.begin(), modes_j.end(), mode.j);
    if (at != modes_j.end()) {
      errors.push_back(look.error[std::size_t(at - modes_j.begin())]);
      continue;
    }
    const auto same = std::find_if(before->modes.begin(), before->modes.end(),
                                   [&](const Mode& one) { return one.j == mode.j; });
    errors.push_back(before->standard_error_waves[std::size_t(same - before->modes.begin())]);
  }
  return errors;
}

Result<void> check_bench(const SensorSnapshot& now) {
  if (!now.registration) {
    return fail(Errc::refused, "", "no registration is in force: call registration.run first");
  }
  if (!now.correction.empty()) {
    return fail(Errc::refused, "", "a correction is shown: call correction.clear first");
  }
  const auto& before = now.slm->flatness;
  if (before && before->pupil_diameter_px != now.sensor.pupil_diameter_px) {
    return fail(Errc::refused, "sensor.pupil_diameter_px",
                fmt::format("a flatness measured over {} SLM pixels is in force, the pupil has {}: "
                            "call flatness.clear first",
                            before->pupil_diameter_px, now.sensor.pupil_diameter_px));
  }
  return {};
}

}  // namespace

Result<MeasuredFlatness> measure_flatness(Bench& bench, const SlmGeometry& slm, int frames) {
  const SensorSnapshot now = bench.sensor();
  if (auto able = check_bench(now); !able) return fail(able.error());
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const Roi roi = bench.camera().settings.roi;
  auto flat_px = flat_spots(now, slm, roi.width, roi.height);
  if (!flat_px) return fail(flat_px.error());
  FlatnessBench looks(
      bench, slope_operator(*lattice, now.sensor, now.tracking, px_per_cycle(now.optics, slm)),
      std::move(*flat_px), frames);

  MeasuredFlatness measured;
  std::vector<Mode> error;
  Look last;
  for (int k = 1; k <= kMostIterations; ++k) {
    bench.tell(double(k - 1) / kMostIterations);
    auto seen = looks.look(error);
    if (!seen) return fail(seen.error());
    last = std::move(*seen);
    error = sum(std::move(error), looks.modes_j(), last.waves);
    measured.iterations = k;
    const double noise = rms(looks.modes_j(), last.error);
    measured.residual_rms_waves = rms(looks.modes_j(), last.waves);
    if (measured.residual_rms_waves < std::max(kLeastResidual, kEnough * noise)) break;
  }
  if (measured.residual_rms_waves > kMostResidual) {
    return fail(
        Errc::refused, "",
        fmt::format("it does not settle: after {} looks {:.3f} waves RMS are left; see that "
                    "nothing moves, and that every spot is found",
                    measured.iterations, measured.residual_rms_waves));
  }
  const double lambda_px = lambda_d_px(now.optics, slm, now.sensor);
  if (last.fit_residual_px > kMostUnexplained * lambda_px) {
    return fail(
        Errc::refused, "",
        fmt::format("no wavefront explains where the spots are, {:.2f} px RMS are left: the "
                    "camera does not stand as it was registered; run registration.run",
                    last.fit_residual_px));
  }
  if (now.slm->flatness) error = sum(std::move(error), now.slm->flatness->modes);
  measured.standard_error_waves = errors_of(error, looks.modes_j(), last, now.slm->flatness.get());
  measured.modes = std::move(error);
  measured.t_taken_ns = utc_ns();
  measured.frames = frames;
  measured.pupil_diameter_px = now.sensor.pupil_diameter_px;
  return measured;
}

}  // namespace ovws
