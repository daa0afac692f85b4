#include "core/wavefront/refine.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "core/base/pixels.hpp"
#include "core/wavefront/refine_system.hpp"

namespace ovws {
namespace {

constexpr double kFirstDamping = 1e-3, kMaxDamping = 1e7;
constexpr double kConverged = 1e-3;    // step^T Fisher step: a thirtieth of a standard error
constexpr double kRoughWaves = 0.005;  // RMS of a step: the descent may end here
constexpr double kMovedWaves = 0.03;   // RMS change after which the stray light is estimated again
constexpr int kMaxStrayEstimates = 3, kMaxSettleIterations = 30;
constexpr double kMaxMixing = 4.0;
constexpr double kMaxWaves = 100.0;  // waves: larger coefficients are unphysical

RefineState moved(RefineState state, const Eigen::VectorXd& step) {
  const Eigen::Index modes = state.waves.size();
  state.waves += step.head(modes);
  state.scale_e *= std::exp(std::clamp(step(modes), -1.0, 1.0));
  state.background_e += step(modes + 1);
  for (std::size_t i = 0; i < state.amplitudes.size(); ++i) {
    state.amplitudes[i] *= std::exp(std::clamp(step(modes + 2 + Eigen::Index(i)), -1.0, 1.0));
  }
  return state;
}

/// The scale and the mean amplitude are degenerate: penalises the sum of the log amplitudes.
void pin_amplitudes(RefineSums& sums, const RefineState& state) {
  if (state.amplitudes.empty()) return;
  const Eigen::Index modes = state.waves.size();
  const auto which = Eigen::seqN(modes + 2, Eigen::Index(state.amplitudes.size()));
  double logarithms = 0.0;
  for (const double amplitude : state.amplitudes) logarithms += std::log(amplitude);
  const double weight = sums.fisher(modes, modes);
  sums.fisher(which, which).array() += weight;
  sums.gradient(which).array() -= weight * logarithms;
}

std::optional<Eigen::VectorXd> step_of(const RefineSums& sums, double damping) {
  Eigen::MatrixXd damped = sums.fisher;
  damped.diagonal() *= 1.0 + damping;
  const Eigen::LDLT<Eigen::MatrixXd> solver(damped);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  Eigen::VectorXd step = solver.solve(sums.gradient);
  if (!step.allFinite()) return std::nullopt;
  return step;
}

std::vector<double> relative(std::vector<double> amplitudes) {
  double squares = 0.0;
  for (const double a : amplitudes) squares += a * a / double(amplitudes.size());
  for (double& a : amplitudes) a /= std::sqrt(squares);
  return amplitudes;
}

Image<float> float_image(const ImageView& view) {
  Image<float> image(view.width, view.height);
  visit_rows(view, 0, 0, view.width, view.height, [&](int x, int y, const auto* pixels, int count) {
    std::copy_n(pixels, count, image.row(y) + x);
  });
  return image;
}

}  // namespace

struct Refiner::Impl {
  RefineSystem system;
  RefineOptions options;

  /// State of a descent.
  struct Descent {
    RefineState state;
    RefineSums sums;
    int iterations = 0;
    bool converged = false;
  };

  Result<Refinement> fit(std::span<const double> start_waves);
  bool stopped() const { return options.stop != nullptr && options.stop->load(); }
  RefineSums summed(const RefineState& state);
  /// Levenberg-Marquardt descent from a propagated state until the steps are small.
  void descend(Descent& descent);
  /// Fixed-point iteration from there to a zero of the gradient, even if the misfit grows. The
  /// misfit depends on far tails of the stray light, which the derivatives leave out.
  void settle(Descent& descent);
  Refinement result(const Descent& descent) const;
  Result<void> check(const Image<float>& dn, const RefineCamera& camera,
                     std::span<const double> start_waves) const;
};

Refiner::Refiner(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Refiner::~Refiner() = default;
Refiner::Refiner(Refiner&&) noexcept = default;
Refiner& Refiner::operator=(Refiner&&) noexcept = default;

Result<Refiner> Refiner::make(const SensorConfig& sensor, const SlmGeometry& slm,
                              const OpticsConfig& optics, int cols, int rows,
                              std::vector<int> modes_j, const RefineOptions& options) {
  const bool valid = std::all_of(modes_j.begin(), modes_j.end(),
                                 [](int j) { return j >= 1 && j <= kMaxZernikeIndex; });
  if (modes_j.empty() || !valid) {
    return fail(Errc::invalid, "modes",
                "give at least one mode, each from j = 1 to " + std::to_string(kMaxZernikeIndex) +
                    ": piston is not visible in an image");
  }
  if (!(options.box_half >= 1.0 && options.box_half <= 20.0)) {
    return fail(Errc::invalid, "refine.box_half", "must be from 1 to 20 in units of lambda/d");
  }
  auto field = SensorField::make(sensor, slm, optics, cols, rows);
  if (!field) return fail(field.error());
  const int half = int(std::ceil(options.box_half * lambda_d_px(optics, slm, sensor)));
  return Refiner(std::make_unique<Impl>(
      Impl{RefineSystem(std::move(*field), std::move(modes_j), half), options}));
}

Result<void> Refiner::Impl::check(const Image<float>& dn, const RefineCamera& camera,
                                  std::span<const double> start_waves) const {
  const FarFieldWindow& w = system.field().window();
  if (dn.width != w.cols || dn.height != w.rows) {
    return fail(Errc::invalid, "image",
                "the image is " + std::to_string(dn.width) + " x " + std::to_string(dn.height) +
                    ", the model " + std::to_string(w.cols) + " x " + std::to_string(w.rows) +
                    ": they must be equal");
  }
  const bool usable = std::all_of(start_waves.begin(), start_waves.end(),
                                  [](double v) { return std::abs(v) < kMaxWaves; });
  if (start_waves.size() != system.modes_j().size() || !usable) {
    return fail(Errc::invalid, "modes",
                "the start must give " + std::to_string(system.modes_j().size()) +
                    " modes, each a number below 100 waves");
  }
  if (!(camera.electrons_per_dn > 0.0 && camera.read_noise_e >= 0.0) ||
      !std::isfinite(camera.electrons_per_dn * camera.read_noise_e + camera.black_dn)) {
    return fail(
        Errc::invalid, "camera",
        "electrons per DN must be above 0, the read noise at least 0, and all values finite");
  }
  return {};
}

Result<Refinement> Refiner::refine(const ImageView& dn, const RefineCamera& camera,
                                   std::span<const double> start_waves) {
  return refine(float_image(dn), camera, start_waves);
}

Result<Refinement> Refiner::refine(const Image<float>& dn, const RefineCamera& camera,
                                   std::span<const double> start_waves) {
  if (auto ok = impl_->check(dn, camera, start_waves); !ok) return fail(ok.error());
  Image<float> electrons = dn;
  for (float& pixel : electrons.pixels) {
    const double value = double(pixel);
    pixel = value < camera.saturated_dn ? float((value - camera.black_dn) * camera.electrons_per_dn)
                                        : NAN;
  }
  impl_->system.set_image(electrons, camera.read_noise_e);
  return impl_->fit(start_waves);
}

RefineSums Refiner::Impl::summed(const RefineState& state) {
  RefineSums sums = system.linearise(state);
  pin_amplitudes(sums, state);
  return sums;
}

void Refiner::Impl::descend(Descent& descent) {
  descent.sums = summed(descent.state);
  descent.converged = false;
  double damping = kFirstDamping;
  for (int k = 0; k < options.max_iterations && damping < kMaxDamping; ++k) {
    const auto step = step_of(descent.sums, damping);
    if (!step || stopped()) return;
    const double size = step->dot(descent.sums.fisher * *step);
    const RefineState next = moved(descent.state, *step);
    const bool near = next.waves.cwiseAbs().maxCoeff() < kMaxWaves;
    if (near) system.propagate(next);
    ++descent.iterations;
    const bool better = near && system.misfit(next) <= descent.sums.chi2;
    descent.converged =
        size < kConverged || step->head(descent.state.waves.size()).norm() < kRoughWaves;
    if (better) {
      descent.state = next;
      descent.sums = summed(descent.state);
    }
    if (descent.converged) {
      if (!better && near) system.propagate(descent.state);  // discards the rejected step
      return;
    }
    damping *= better ? 0.1 : 10.0;
  }
}

void Refiner::Impl::settle(Descent& descent) {
  descent.sums = summed(descent.state);
  descent.converged = false;
  Eigen::VectorXd last_full_step, last_step;
  double last_size = 0.0;
  for (int k = 0; k < kMaxSettleIterations; ++k) {
    const auto full_step = step_of(descent.sums, 0.0);
    if (!full_step || stopped()) return;
    const double size = full_step->dot(descent.sums.fisher * *full_step);
    Eigen::VectorXd step = *full_step;
    if (k > 0 && size < last_size) {
      // Anderson mixing of depth one: accelerates steps that shrink slowly.
      const Eigen::VectorXd change = *full_step - last_full_step;
      const Eigen::VectorXd weighted = descent.sums.fisher * change;
      const double back =
          std::clamp(weighted.dot(*full_step) / weighted.dot(change), -kMaxMixing, 0.0);
      step -= back * (last_step + change);
    }
    if (!(step.head(descent.state.waves.size()).norm() < kMovedWaves)) return;
    descent.state = moved(descent.state, step);
    system.propagate(descent.state);
    descent.sums = summed(descent.state);
    ++descent.iterations;
    descent.converged = size < kConverged;
    if (descent.converged) return;
    last_full_step = *full_step;
    last_step = step;
    last_size = size;
  }
}

Result<Refinement> Refiner::Impl::fit(std::span<const double> start_waves) {
  Descent descent;
  descent.state.waves = Eigen::Map<const Eigen::VectorXd>(start_waves.data(), start_waves.size());
  if (options.spot_amplitudes) descent.state.amplitudes.assign(system.field().subapertures(), 1.0);
  system.treat_outside_as_noise(descent.state);
  system.fit_scale_and_background(descent.state);
  if (!(descent.state.scale_e > 0.0)) {
    return fail(
        Errc::refused, "image",
        "no signal at the spots that the model predicts: check the exposure, and that optics, "
        "sensor and slm in the configuration match the bench");
  }
  for (int estimate = 1;; ++estimate) {
    const Eigen::VectorXd before = descent.state.waves;
    descend(descent);
    if (!descent.converged) break;
    if (estimate == kMaxStrayEstimates || (descent.state.waves - before).norm() < kMovedWaves)
      break;
    system.treat_outside_as_noise(descent.state);
  }
  if (descent.converged && options.model_outside) {
    Descent modelled = descent;
    system.model_outside();
    system.propagate(modelled.state);
    settle(modelled);
    const auto by_pixel = [](const RefineSums& s) { return s.deviance / double(s.pixels); };
    if (modelled.converged && by_pixel(modelled.sums) < by_pixel(descent.sums))
      return result(modelled);
    descent.iterations = modelled.iterations;
    system.treat_outside_as_noise(descent.state);
  }
  if (descent.converged) settle(descent);
  if (stopped()) return fail(Errc::refused, "image", "cancelled");
  if (descent.converged) return result(descent);
  return fail(Errc::refused, "image",
              "the fit did not converge in " + std::to_string(options.max_iterations) +
                  " iterations: reduce the aberration, or take a new reference");
}

Refinement Refiner::Impl::result(const Descent& descent) const {
  const Eigen::Index count = descent.state.waves.size();
  const Eigen::Index size = descent.sums.fisher.rows();
  const Eigen::LDLT<Eigen::MatrixXd> solver(descent.sums.fisher);
  Refinement r;
  r.covariance = solver.solve(Eigen::MatrixXd::Identity(size, size)).topLeftCorner(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    r.modes.push_back({system.modes_j()[std::size_t(k)], descent.state.waves(k)});
    r.sigma_waves.push_back(std::sqrt(r.covariance(k, k)));
  }
  r.peak_e = descent.state.scale_e * system.brightest();
  r.background_e = descent.state.background_e;
  r.amplitudes = relative(descent.state.amplitudes);
  r.iterations = descent.iterations;
  r.pixels = int(descent.sums.pixels);
  r.chi2_per_pixel = descent.sums.chi2 / double(std::max<Eigen::Index>(1, r.pixels - size));
  return r;
}

}  // namespace ovws
