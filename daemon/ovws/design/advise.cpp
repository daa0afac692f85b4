#include "daemon/ovws/design/advise.hpp"

#include <algorithm>

#include "core/spots/mode_limit.hpp"
#include "daemon/ovws/design/attempt.hpp"
#include "daemon/ovws/design/search.hpp"

namespace ovws::design {
namespace {

constexpr std::array<int, 6> kAcross{3, 5, 7, 9, 11, 13};

/// Errors at this peak, and how much of the light the spots receive.
Result<ModeErrors> errors_at(const Config& config, int modes, const Light& light, double peak_e) {
  const Roi& roi = config.camera.settings.roi;
  const LitPixels lit =
      lit_pixels(config.camera.settings.pixel_format, config.optics.wavelength_nm);
  return mode_errors({config.sensor, config.slm.geometry, config.optics, roi.width, roi.height,
                      config.tracking.estimates, lit, peak_e, light.read_noise_e},
                     modes);
}

/// The design of this sensor: gratings of at least four SLM pixels a period, if possible.
tl::expected<Config, Finding> designed(const Bench& bench, const Config& base, int across) {
  const bool by_shapes = optimal_mode_count(across) < *bench.modes;
  const Candidate candidate = make_candidate(bench, base, across, by_shapes);
  auto config = attempt(candidate, kComfortableCpp);
  return config ? config : attempt(candidate, kNyquistCpp);
}

tl::expected<Advice, std::string> advice_for(const Config& config, int modes, const Light& light) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  const double peak_limit_e = kFill * light.full_well_e;
  const auto scale = errors_at(config, modes, light, peak_limit_e);
  if (!scale) return tl::make_unexpected(text_of(scale.error()));
  Advice advice;
  advice.subapertures_across = config.sensor.subapertures_across;
  advice.subapertures = int(lattice->subapertures.size());
  advice.charge = config.sensor.charge;
  advice.config = config;
  const double covered =
      advice.subapertures / double(advice.subapertures_across * advice.subapertures_across);
  const double peak_e_per_us = 1e-6 * light.e_per_s * covered / scale->light_per_peak;
  const double full_us = peak_limit_e / peak_e_per_us;
  advice.limited_by = full_us < light.longest_us ? ExposureLimit::full_well : ExposureLimit::time;
  advice.exposure_us = std::min(full_us, light.longest_us);
  advice.peak_e = peak_e_per_us * advice.exposure_us;
  advice.config.camera.settings.exposure_us = advice.exposure_us;
  const auto errors = errors_at(config, modes, light, advice.peak_e);
  if (!errors) return tl::make_unexpected(text_of(errors.error()));
  if (!errors->are_determined()) {
    return tl::make_unexpected(
        "at this light its spots do not determine the modes: the largest "
        "standard error is more than twice that of a lone tilt");
  }
  advice.error_waves = errors->rms_waves;
  advice.worst_waves = errors->worst_waves;
  return advice;
}

}  // namespace

AdviceList advise(const Bench& bench, const Light& light, const Config& base,
                  const std::function<bool()>& stopped) {
  AdviceList all;
  for (const int across : kAcross) {
    for (const int charge : kAdvisedCharges) {
      if (stopped()) return all;
      Bench with = bench;
      with.charge = charge;
      const auto config = designed(with, base, across);
      if (!config) {
        all.unfit.push_back({across, charge, config.error().reason});
        continue;
      }
      auto advice = advice_for(*config, *bench.modes, light);
      if (!advice) {
        all.unfit.push_back({across, charge, advice.error()});
        continue;
      }
      all.best_first.push_back(std::move(*advice));
    }
  }
  std::stable_sort(all.best_first.begin(), all.best_first.end(),
                   [](const Advice& a, const Advice& b) { return a.error_waves < b.error_waves; });
  return all;
}

}  // namespace ovws::design
