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

constexpr double kFirstDamping = 1e-3, kMostDamping = 1e7;
constexpr double kDone = 1e-3;         // step^T Fisher step: a thirtieth of a standard error
constexpr double kRoughWaves = 0.005;  // RMS of a step: the descent may end here
constexpr double kMovedWaves = 0.03;   // RMS change after which the stray light is estimated again
constexpr int kMostGuesses = 3, kMostSettling = 30;
constexpr double kMostMixing = 4.0;
constexpr double kTooFar = 100.0;  // waves: larger coefficients are unphysical

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
void pin_amplitudes(RefineSums& sums, Eigen::Index modes, Eigen::Index spots) {
  if (spots == 0) return;
  const auto which = Eigen::seqN(modes + 2, spots);
  sums.fisher(which, which).array() += sums.fisher(modes, modes);
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

Image<float> numbers_of(const ImageView& view) {
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
  struct Place {
    RefineState state;
    RefineSums sums;
    int iterations = 0;
    bool minimum = false;
  };

  Result<Refinement> fit(std::span<const double> start_waves);
  bool stopped() const { return options.stop != nullptr && options.stop->load(); }
  RefineSums summed(const RefineState& state);
  /// Levenberg-Marquardt descent from a propagated state until the steps are small.
  void descend(Place& place);
  /// Fixed-point iteration from there to a zero of the gradient, even if the misfit grows. The
  /// misfit depends on far tails of the stray light, which the derivatives leave out.
  void settle(Place& place);
  Refinement result(const Place& place) const;
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
  const bool known = std::all_of(modes_j.begin(), modes_j.end(),
                                 [](int j) { return j >= 1 && j <= kMaxZernikeIndex; });
  if (modes_j.empty() || !known) {
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
                                  [](double v) { return std::abs(v) < kTooFar; });
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
  return refine(numbers_of(dn), camera, start_waves);
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
  impl_->system.see(electrons, camera.read_noise_e);
  return impl_->fit(start_waves);
}

RefineSums Refiner::Impl::summed(const RefineState& state) {
  RefineSums sums = system.linearise(state);
  pin_amplitudes(sums, state.waves.size(), Eigen::Index(state.amplitudes.size()));
  return sums;
}

void Refiner::Impl::descend(Place& place) {
  place.sums = summed(place.state);
  place.minimum = false;
  double damping = kFirstDamping;
  for (int k = 0; k < options.most_iterations && damping < kMostDamping; ++k) {
    const auto step = step_of(place.sums, damping);
    if (!step || stopped()) return;
    const double size = step->dot(place.sums.fisher * *step);
    const RefineState next = moved(place.state, *step);
    const bool near = next.waves.cwiseAbs().maxCoeff() < kTooFar;
    if (near) system.propagate(next);
    ++place.iterations;
    const bool better = near && system.misfit(next) <= place.sums.chi2;
    place.minimum = size < kDone || step->head(place.state.waves.size()).norm() < kRoughWaves;
    if (better) {
      place.state = next;
      place.sums = summed(place.state);
    }
    if (place.minimum) {
      if (!better && near) system.propagate(place.state);  // discards the rejected step
      return;
    }
    damping *= better ? 0.1 : 10.0;
  }
}

void Refiner::Impl::settle(Place& place) {
  place.sums = summed(place.state);
  place.minimum = false;
  Eigen::VectorXd last_pull, last_step;
  double last_size = 0.0;
  for (int k = 0; k < kMostSettling; ++k) {
    const auto pull = step_of(place.sums, 0.0);
    if (!pull || stopped()) return;
    const double size = pull->dot(place.sums.fisher * *pull);
    Eigen::VectorXd step = *pull;
    if (k > 0 && size < last_size) {
      // Anderson mixing of depth one: accelerates steps that shrink slowly.
      const Eigen::VectorXd change = *pull - last_pull;
      const Eigen::VectorXd weighted = place.sums.fisher * change;
      const double back = std::clamp(weighted.dot(*pull) / weighted.dot(change), -kMostMixing, 0.0);
      step -= back * (last_step + change);
    }
    if (!(step.head(place.state.waves.size()).norm() < kMovedWaves)) return;
    place.state = moved(place.state, step);
    system.propagate(place.state);
    place.sums = summed(place.state);
    ++place.iterations;
    place.minimum = size < kDone;
    if (place.minimum) return;
    last_pull = *pull;
    last_step = step;
    last_size = size;
  }
}

Result<Refinement> Refiner::Impl::fit(std::span<const double> start_waves) {
  Place place;
  place.state.waves = Eigen::Map<const Eigen::VectorXd>(start_waves.data(), start_waves.size());
  if (options.spot_amplitudes) place.state.amplitudes.assign(system.field().subapertures(), 1.0);
  system.doubt_outside(place.state);
  system.match_light(place.state);
  if (!(place.state.scale_e > 0.0)) {
    return fail(
        Errc::refused, "image",
        "no light where the model has it: start nearer to the truth, or check the exposure");
  }
  for (int guess = 1;; ++guess) {
    const Eigen::VectorXd before = place.state.waves;
    descend(place);
    if (!place.minimum) break;
    if (guess == kMostGuesses || (place.state.waves - before).norm() < kMovedWaves) break;
    system.doubt_outside(place.state);
  }
  if (place.minimum && options.model_outside) {
    Place modelled = place;
    system.model_outside();
    system.propagate(modelled.state);
    settle(modelled);
    const auto by_pixel = [](const RefineSums& s) { return s.deviance / double(s.pixels); };
    if (modelled.minimum && by_pixel(modelled.sums) < by_pixel(place.sums)) return result(modelled);
    place.iterations = modelled.iterations;
    system.doubt_outside(place.state);
  }
  if (place.minimum) settle(place);
  if (stopped()) return fail(Errc::refused, "image", "cancelled");
  if (place.minimum) return result(place);
  return fail(Errc::refused, "image",
              "the fit did not converge in " + std::to_string(options.most_iterations) +
                  " iterations: start nearer to the truth");
}

Refinement Refiner::Impl::result(const Place& place) const {
  const Eigen::Index count = place.state.waves.size();
  const Eigen::Index size = place.sums.fisher.rows();
  const Eigen::LDLT<Eigen::MatrixXd> solver(place.sums.fisher);
  Refinement r;
  r.covariance = solver.solve(Eigen::MatrixXd::Identity(size, size)).topLeftCorner(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    r.modes.push_back({system.modes_j()[std::size_t(k)], place.state.waves(k)});
    r.sigma_waves.push_back(std::sqrt(r.covariance(k, k)));
  }
  r.peak_e = place.state.scale_e * system.brightest();
  r.background_e = place.state.background_e;
  r.amplitudes = relative(place.state.amplitudes);
  r.iterations = place.iterations;
  r.pixels = int(place.sums.pixels);
  r.chi2_per_pixel = place.sums.chi2 / double(std::max<Eigen::Index>(1, r.pixels - size));
  return r;
}

}  // namespace ovws
