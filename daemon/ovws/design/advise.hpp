/// Advice on the sensor of a bench: how many subapertures, which charge and which exposure give the
/// smallest error for the light and the modes that are wanted. Pure functions.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "daemon/ovws/design/design.hpp"

namespace ovws::design {

/// Light and camera noise, in photo-electrons.
struct Light {
  double e_per_s = 0.0;  ///< of the whole pupil's light on the camera
  double full_well_e = 10'000.0;
  double read_noise_e = 5.0;
  double longest_us = 10'000.0;  ///< longest exposure
};

/// What limits the exposure.
enum class ExposureLimit {
  full_well,  ///< the brightest pixel: more light does not help
  time        ///< the longest exposure: more light, or a lower frame rate, helps
};

/// A sensor that works on the bench, with its expected error.
struct Advice {
  int subapertures_across = 0, subapertures = 0, charge = 0;
  double exposure_us = 0.0;
  double peak_e = 0.0;       ///< in the brightest pixel
  double error_waves = 0.0;  ///< root sum square over the wanted modes without tilts
  double worst_waves = 0.0;  ///< largest standard error of a mode
  ExposureLimit limited_by{};
  Config config;
  std::string warning;  ///< by advise_on, about stray light of the zeroth order; empty: none
};

/// A sensor that does not work, and why.
struct Unfit {
  int subapertures_across = 0, charge = 0;
  std::string reason;
  double needed_e_per_s = 0.0;  ///< light from which its spots are found; 0: it lacks no light
};

struct AdviceList {
  std::vector<Advice> best_first;  ///< by error_waves
  std::vector<Unfit> unfit;
};

/// Charges that are compared. Higher ones need more room and were never better.
constexpr std::array<int, 3> kAdvisedCharges{0, 1, 2};

/// Share of the full well that the brightest pixel may reach: room for aberrations.
constexpr double kFill = 0.7;

/// Least signal-to-noise ratio of the brightest pixel at which spots count as found. Measured with
/// the images of `ovws study acquisition --quick`, 13 px to lambda/d, and more noise: `fit` finds
/// all spots at 1.5, 84 % at 1, none at 0.5.
constexpr double kLeastSnr = 1.0;

/// Compares sensors for `bench.modes` modes, which must be given, on this bench. Errors are
/// standard errors of the tracker `fit` about a flat wavefront. Takes some seconds. Deterministic.
AdviceList advise(const Bench& bench, const Light& light, const Config& base = {});

/// The advice for the sensor that a configuration describes, as it is. Errors: as
/// AdviceList::unfit.
tl::expected<Advice, Unfit> advise_on(const Config& config, int modes, const Light& light);

}  // namespace ovws::design
