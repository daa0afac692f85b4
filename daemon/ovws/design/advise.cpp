#include "daemon/ovws/design/advise.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/spots/mode_limit.hpp"
#include "daemon/ovws/design/search.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"

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

/// Electrons in the brightest pixel at kLeastSnr: P / sqrt(P + read noise^2) = kLeastSnr.
double least_peak_e(double read_noise_e) {
  constexpr double kSquare = kLeastSnr * kLeastSnr;
  return 0.5 * (kSquare + std::sqrt(kSquare * (kSquare + 4.0 * read_noise_e * read_noise_e)));
}

/// Why spots with the advice's peak are not found; none: they are.
std::optional<Unfit> too_dim(const Advice& advice, const Light& light) {
  const double least_e = least_peak_e(light.read_noise_e);
  if (advice.peak_e >= least_e) return std::nullopt;
  const std::string peak = fmt::format(
      "its spots have {:.2g} electrons in the brightest pixel, and are found from {:.2g} "
      "on at this read noise",
      advice.peak_e, least_e);
  Unfit unfit{advice.subapertures_across, advice.charge, "", 0.0};
  if (advice.limited_by == ExposureLimit::full_well) {
    unfit.reason = "the read noise is too large for this full well: " + peak;
    return unfit;
  }
  unfit.needed_e_per_s = light.e_per_s * least_e / advice.peak_e;
  unfit.reason = fmt::format(
      "the light is too low: {}; that takes {:.2g} photo-electrons per second, or a longer "
      "exposure",
      peak, unfit.needed_e_per_s);
  return unfit;
}

tl::expected<Advice, Unfit> advice_for(const Config& config, int modes, const Light& light) {
  const auto unfit = [&config](std::string reason) {
    return tl::make_unexpected(
        Unfit{config.sensor.subapertures_across, config.sensor.charge, std::move(reason)});
  };
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return unfit(text_of(lattice.error()));
  const double peak_limit_e = kFill * light.full_well_e;
  const auto scale = errors_at(config, modes, light, peak_limit_e);
  if (!scale) return unfit(text_of(scale.error()));
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
  auto dim = too_dim(advice, light);
  const double peak_e = dim ? least_peak_e(light.read_noise_e) : advice.peak_e;
  const auto errors = errors_at(config, modes, light, peak_e);
  if (!errors) return unfit(text_of(errors.error()));
  if (!errors->are_determined()) {
    return unfit(
        "at this light its spots do not determine the modes: the largest "
        "standard error is more than twice that of a lone tilt");
  }
  if (dim) return tl::make_unexpected(std::move(*dim));
  advice.error_waves = errors->rms_waves;
  advice.worst_waves = errors->worst_waves;
  return advice;
}

}  // namespace

tl::expected<Advice, Unfit> advise_on(const Config& config, int modes, const Light& light) {
  if (const auto seen = check_sees_spots(config); !seen) {
    return tl::make_unexpected(
        Unfit{config.sensor.subapertures_across, config.sensor.charge, text_of(seen.error()), 0.0});
  }
  auto advice = advice_for(config, modes, light);
  const auto dark = check_zeroth_order(config);
  if (advice && !dark) advice->warning = text_of(dark.error());
  return advice;
}

AdviceList advise(const Bench& bench, const Light& light, const Config& base) {
  AdviceList all;
  for (const int across : kAcross) {
    for (const int charge : kAdvisedCharges) {
      Bench with = bench;
      with.charge = charge;
      const auto config = designed(with, base, across);
      if (!config) {
        all.unfit.push_back({across, charge, config.error().reason, 0.0});
        continue;
      }
      auto advice = advice_for(*config, *bench.modes, light);
      if (!advice) {
        all.unfit.push_back(std::move(advice.error()));
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
