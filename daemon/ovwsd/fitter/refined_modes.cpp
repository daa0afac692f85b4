#include "daemon/ovwsd/fitter/refined_modes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr int kRenderings = 20;
// Templates of an earlier image are used again up to these limits.
constexpr double kMaxBent = 0.2;       // error by the drift over the standard error
constexpr double kMaxBrighter = 0.05;  // change of the intensity, fraction
constexpr double kMaxOverPoint = 1.2;  // residual over that of their own image

/// Field amplitudes of the subapertures, RMS 1. A spot's level is relative to its rendering, so the
/// amplitude is that of the rendering, which comes from the reference, times the root of the level.
std::vector<double> amplitudes_of(const PointModel& model,
                                  const std::vector<SpotEstimates>& estimates) {
  std::vector<double> amplitudes;
  double squares = 0.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double level = std::max(0.0, double(estimates[i].level));
    amplitudes.push_back(std::sqrt(level) * model.amplitude(int(i)));
    squares += amplitudes.back() * amplitudes.back() / double(estimates.size());
  }
  for (double& one : amplitudes) one /= std::sqrt(std::max(squares, 1e-30));
  return amplitudes;
}

/// Whether templates of an earlier image, which measured `all`, are as good as the image's own.
bool are_exact(const FrameFit& fit, const FrameFit::Measured& all, const PixelNoise& noise,
               std::span<const Mode> fixed) {
  const bool same_setup =
      fit.point().noise == noise && std::ranges::equal(fit.point().fixed, fixed);
  if (!same_setup || !all.frame.credible) return false;
  double variance = 0.0;
  for (const float sigma : all.sigma_waves) variance += double(sigma) * double(sigma);
  return all.frame.bent_waves < kMaxBent * std::sqrt(variance) &&
         std::abs(all.frame.brightness - 1.0) < kMaxBrighter &&
         all.frame.lost <= fit.at_point().lost &&
         all.frame.residual < kMaxOverPoint * std::max(1.0, fit.at_point().residual);
}

RefinedModes modes_of(const PointModel& model, const FrameFit& fit, const FrameFit::Measured& all,
                      const RefineCamera& camera, int iterations) {
  RefinedModes modes;
  modes.waves.assign(all.coefficients.begin(), all.coefficients.end());
  for (std::size_t k = 0; k < modes.waves.size(); ++k) {
    modes.sigma_waves.push_back(
        std::hypot(double(all.sigma_waves[k]), model.reference_sigma_waves()[k]));
  }
  const std::vector<SpotTemplates>& spots = fit.spots().spots();
  double peak_dn = 0.0;
  int lit = 0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const SpotEstimates& found = all.estimates[i];
    if (!(found.level > 0.0F)) continue;
    ++lit;
    modes.chi2_per_pixel += double(found.chi2_per_cell);
    modes.background_e += (double(found.background) - camera.black_dn) * camera.electrons_per_dn;
    peak_dn = std::max(peak_dn, double(found.level) * spots[i].brightest_intensity);
  }
  modes.chi2_per_pixel /= std::max(lit, 1);
  modes.background_e /= std::max(lit, 1);
  modes.peak_e = peak_dn * camera.electrons_per_dn;
  modes.iterations = iterations;
  modes.higher_waves = fit.point().higher_waves;
  modes.amplitudes = amplitudes_of(model, all.estimates);
  return modes;
}

}  // namespace

PixelNoise pixel_noise(const RefineCamera& camera) {
  const double read_noise_dn = camera.read_noise_e / camera.electrons_per_dn;
  return {read_noise_dn * read_noise_dn, 1.0 / camera.electrons_per_dn, camera.saturated_dn};
}

RefineCamera refine_camera(const RefineSetup& stated, PixelFormat format, double gain_db) {
  const RefineSetup settings = in_format(stated, format);
  RefineCamera camera;
  camera.electrons_per_dn = *settings.electrons_per_dn * std::pow(10.0, -gain_db / 20.0);
  camera.read_noise_e = std::hypot(settings.read_noise_e, rounding_e(camera.electrons_per_dn));
  camera.black_dn = settings.black_level_dn;
  const double full = full_scale_dn(format);
  camera.saturated_dn = std::min(settings.saturation_dn.value_or(full), full);
  return camera;
}

std::optional<std::string> RefinedModes::doubt(const RefineCamera& camera) const {
  constexpr double kMinPeak = 1.0;  // times the read noise; low, for a fit uses many pixels
  constexpr double kMaxSigmaWaves = 0.1;
  constexpr double kMaxChi2 = 3.0;  // above 1, because the configured noise may be inexact
  const double max_sigma = *std::max_element(sigma_waves.begin(), sigma_waves.end());
  if (!(peak_e > kMinPeak * std::max(camera.read_noise_e, 1.0))) {
    return fmt::format(
        "the brightest pixel ({:.0f} electrons) is below the read noise: increase the exposure",
        peak_e);
  }
  const bool determined = std::all_of(sigma_waves.begin(), sigma_waves.end(), [](double sigma) {
    return sigma < kMaxSigmaWaves;
  });  // false for NaN
  if (!determined) {
    return fmt::format(
        "too few photons to determine all modes: the largest standard error is {:.2f} wave; "
        "increase the exposure",
        max_sigma);
  }
  const bool explained =
      chi2_per_pixel < kMaxChi2 || (higher_waves > 0.0 && std::isfinite(chi2_per_pixel));
  if (!explained) {
    return fmt::format(
        "the model does not explain the image (chi2 per pixel is {:.1f}): check the "
        "configured noise, the optics and the illumination",
        chi2_per_pixel);
  }
  return std::nullopt;
}

Result<RefinedModes> refine(PointModel& model, const ImageView& image, const RefineCamera& camera,
                            PointModel::Starts starts, std::span<const Mode> fixed,
                            std::shared_ptr<const FrameFit>& templates) {
  const PixelNoise noise = pixel_noise(camera);
  if (templates) {
    const FrameFit::Measured all = templates->measure(image);
    if (are_exact(*templates, all, noise, fixed))
      return modes_of(model, *templates, all, camera, 0);
  }
  auto found = model.templates(image, noise, starts, fixed, kRenderings);
  if (!found) return fail(found.error());
  templates = std::move(*found);
  return modes_of(model, *templates, templates->measure(image), camera, model.renderings());
}

Result<RefinedModes> refine_absolute(PointModel& model, const ImageView& image,
                                     const RefineCamera& camera, PointModel::Starts starts,
                                     std::span<const Mode> fixed) {
  model.use_model();
  const PixelNoise noise = pixel_noise(camera);
  const auto near = model.templates(image, noise, starts, fixed, kRenderings);
  if (!near) return fail(near.error());
  if ((*near)->point().higher_waves > 0.0) {
    return fail(
        Errc::refused, "image",
        "the wavefront has modes above the measured ones: set a larger tracking.mode_count");
  }
  const std::vector<float> found = (*near)->measure(image).coefficients;
  const std::vector<double> waves(found.begin(), found.end());
  if (auto used = model.use_reference(image, noise, waves, fixed); !used) return fail(used.error());
  const std::vector<std::vector<double>> none{std::vector<double>(waves.size())};
  const auto fit = model.templates(image, noise, none, fixed, kRenderings);
  if (!fit) return fail(fit.error());
  RefinedModes modes = modes_of(model, **fit, (*fit)->measure(image), camera, model.renderings());
  for (std::size_t k = 0; k < waves.size(); ++k) {
    modes.waves[k] += model.reference_waves()[k];
    modes.sigma_waves[k] = model.reference_sigma_waves()[k];
  }
  return modes;
}

}  // namespace ovws
