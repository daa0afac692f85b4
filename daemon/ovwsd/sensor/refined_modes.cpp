#include "daemon/ovwsd/sensor/refined_modes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace ovws {

RefineCamera refine_camera(const RefineSettings& stated, PixelFormat format, double gain_db,
                           int frames) {
  const RefineSettings settings = in_format(stated, format);
  const double electrons_per_dn = *settings.electrons_per_dn * std::pow(10.0, -gain_db / 20.0);
  // The mean of N frames is their sum divided by N, so one DN of it stands for N times the
  // electrons.
  RefineCamera camera;
  camera.electrons_per_dn = electrons_per_dn * frames;
  camera.read_noise_e =
      std::hypot(settings.read_noise_e, rounding_e(electrons_per_dn)) * std::sqrt(double(frames));
  camera.black_dn = settings.black_level_dn;
  const double full = full_scale_dn(format);
  camera.saturated_dn = std::min(settings.saturation_dn.value_or(full), full);
  return camera;
}

std::optional<std::string> RefinedModes::doubt(const RefineCamera& camera, int frames) const {
  constexpr double kMinPeak = 1.0;  // times the read noise: the fit uses thousands of pixels
  constexpr double kMaxSigmaWaves = 0.1;
  constexpr double kMaxChi2 = 3.0;  // above 1: the configured noise may be somewhat off
  const double max_sigma = *std::max_element(sigma_waves.begin(), sigma_waves.end());
  if (!(peak_e > kMinPeak * std::max(camera.read_noise_e, 1.0))) {
    return fmt::format(
        "the brightest pixel ({:.0f} electrons) is below the read noise: increase the exposure",
        peak_e);
  }
  const bool determined = std::all_of(sigma_waves.begin(), sigma_waves.end(), [](double sigma) {
    return sigma < kMaxSigmaWaves;
  });  // no NaN
  if (!determined) {
    return fmt::format(
        "too few photons to determine all modes: the largest standard error is {:.2f} wave; "
        "increase the exposure",
        max_sigma);
  }
  if (!((chi2_per_pixel - 1.0) / frames + 1.0 < kMaxChi2)) {
    return fmt::format(
        "the model does not explain the image (chi2 per pixel is {:.1f}): check the "
        "configured noise, the optics and the illumination",
        chi2_per_pixel);
  }
  return std::nullopt;
}

RefinedModes refined_modes(const Refinement& found) {
  RefinedModes modes;
  for (const Mode& mode : found.modes) modes.waves.push_back(mode.waves);
  modes.sigma_waves = found.sigma_waves;
  modes.chi2_per_pixel = found.chi2_per_pixel;
  modes.peak_e = found.peak_e;
  modes.background_e = found.background_e;
  modes.iterations = found.iterations;
  modes.amplitudes = found.amplitudes;
  return modes;
}

RefinedModes minus(RefinedModes found, const RefinedModes& reference) {
  for (std::size_t k = 0; k < found.waves.size(); ++k) {
    found.waves[k] -= reference.waves[k];
    found.sigma_waves[k] = std::hypot(found.sigma_waves[k], reference.sigma_waves[k]);
  }
  return found;
}

}  // namespace ovws
