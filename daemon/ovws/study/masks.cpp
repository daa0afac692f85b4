/// Study `masks`: which phase mask in every subaperture gives the smallest error of the modes, by
/// the Cramer-Rao bound and by the shapes of the spots.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/mode_bench.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

/// Masks of one shape, whose strength varies.
struct Shape {
  const char* name;
  int charge;
  std::optional<int> alternate;  ///< charge of every second subaperture
  int mode_j;                    ///< Zernike mode over the subaperture; kAxicon: a cone
  bool quick;                    ///< whether the quick form has it
};
constexpr int kAxicon = 0;
constexpr std::array<Shape, 13> kShapes{{
    {"bright, astigmatism", 0, std::nullopt, 3, true},
    {"bright, defocus", 0, std::nullopt, 4, true},
    {"bright, trefoil", 0, std::nullopt, 9, false},
    {"bright, coma", 0, std::nullopt, 8, false},
    {"bright, axicon", 0, std::nullopt, kAxicon, false},
    {"vortex, astigmatism", 1, std::nullopt, 3, true},
    {"vortex, defocus", 1, std::nullopt, 4, true},
    {"vortex, trefoil", 1, std::nullopt, 9, false},
    {"vortex, coma", 1, std::nullopt, 8, false},
    {"vortex, axicon", 1, std::nullopt, kAxicon, false},
    {"charges 1 and -1, astigmatism", 1, -1, 3, true},
    {"charges 0 and 1, astigmatism", 0, 1, 3, false},
    {"charge 2, astigmatism", 2, std::nullopt, 3, false},
}};

struct Candidate {
  std::size_t shape = 0;
  double waves = 0.0;  ///< RMS of the mask over the subaperture; 0: the charge alone
};

constexpr std::array<int, 3> kMaskModes{18, 27, 44};
constexpr std::size_t kMeasured = kMaskModes.size() * kBudgets.size();

Geometry masked_geometry(const Candidate& candidate) {
  const Shape& shape = kShapes[candidate.shape];
  Geometry geometry = default_bench();
  geometry.sensor.charge = shape.charge;
  geometry.sensor.alternate_charge = shape.alternate;
  if (candidate.waves == 0.0) return geometry;
  MaskConfig& mask = geometry.sensor.masks.emplace_back();
  if (shape.mode_j == kAxicon) {
    mask.axicon_waves = candidate.waves;
  } else {
    mask.modes = {{shape.mode_j, candidate.waves}};
  }
  return geometry;
}

/// Every shape at every strength. Shapes that begin with the same charges share strength 0.
std::vector<Candidate> candidates_of(bool quick) {
  const std::vector<double> strengths =
      quick ? std::vector<double>{0.0, 0.15, 0.3}
            : std::vector<double>{0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5};
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < kShapes.size(); ++k) {
    if (quick && !kShapes[k].quick) continue;
    for (const double waves : strengths) candidates.push_back({k, waves});
  }
  return candidates;
}

/// Errors of a candidate for every number of modes at every light level, modes inside.
std::vector<ModeErrors> measure_mask(const Candidate& candidate, int images, std::uint64_t seed) {
  std::vector<ModeErrors> errors;
  const Geometry geometry = masked_geometry(candidate);
  for (const Budget budget : kBudgets) {
    for (const int modes : kMaskModes) {
      errors.push_back(measure_modes(geometry, budget, modes, images, seed++));
    }
  }
  return errors;
}

using Errors = std::vector<std::vector<ModeErrors>>;

nlohmann::json mask_row(const Candidate& candidate, Budget budget, int modes,
                        const ModeErrors& errors) {
  const Shape& shape = kShapes[candidate.shape];
  return {{"mask", shape.name},
          {"charge", shape.charge},
          {"alternate_charge", shape.alternate ? nlohmann::json(*shape.alternate) : nullptr},
          {"strength_waves", candidate.waves},
          {"light", name_of(budget)},
          {"modes", modes},
          {"bound_waves", errors.bound},
          {"shapes_waves", errors.shapes.value},
          {"shapes_standard_error_waves", errors.shapes.standard_error},
          {"shapes_expected_waves", errors.shapes_expected},
          {"positions_expected_waves", errors.positions_expected},
          {"images", errors.shapes.count}};
}

/// Index of the candidate with the smallest expected error by shapes.
std::size_t best_candidate(const Errors& errors, std::size_t at) {
  const auto expected = [at](const std::vector<ModeErrors>& one) {
    const double value = one[at].shapes_expected;
    return std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
  };
  return std::size_t(
      std::min_element(errors.begin(), errors.end(),
                       [&](const auto& a, const auto& b) { return expected(a) < expected(b); }) -
      errors.begin());
}

/// Figure for one number of modes at one light level: error by shapes and bound against strength.
Figure mask_figure(std::size_t at, const std::vector<Candidate>& candidates, const Errors& errors) {
  const Budget budget = kBudgets[at / kMaskModes.size()];
  const int modes = kMaskModes[at % kMaskModes.size()];
  Figure figure{
      fmt::format("masks-{}{}", modes, budget == Budget::peak ? "" : "-photons"),
      fmt::format("19 subapertures, {} modes, flat wavefront, {}", modes, name_of(budget)),
      "strength of the mask (waves RMS over a subaperture)",
      "expected error without tilts (waves RMS)"};
  figure.log_y = true;
  for (std::size_t k = 0; k < kShapes.size(); ++k) {
    Series shapes{kShapes[k].name, {}, {}, {}};
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      if (candidates[c].shape != k) continue;
      const double expected = errors[c][at].shapes_expected;
      if (std::isfinite(expected)) shapes.add(candidates[c].waves, expected);
    }
    if (!shapes.x.empty()) figure.series.push_back(std::move(shapes));
  }
  return figure;
}

Findings masks_findings(const std::vector<Candidate>& candidates, const Errors& errors) {
  Findings findings;
  findings.summary = {{"study", "masks"},
                      {"unit", "waves"},
                      {"peak_e", kPeakE},
                      {"photons_e", kPhotonsE},
                      {"read_noise_e", kModesReadNoiseE},
                      {"rows", nlohmann::json::array()},
                      {"best", nlohmann::json::array()}};
  for (std::size_t at = 0; at < kMeasured; ++at) {
    const Budget budget = kBudgets[at / kMaskModes.size()];
    const int modes = kMaskModes[at % kMaskModes.size()];
    const auto row = [&](std::size_t c) {
      return mask_row(candidates[c], budget, modes, errors[c][at]);
    };
    for (std::size_t c = 0; c < candidates.size(); ++c) findings.summary["rows"].push_back(row(c));
    findings.summary["best"].push_back(row(best_candidate(errors, at)));
    findings.figures.push_back(mask_figure(at, candidates, errors));
  }
  return findings;
}

}  // namespace

Work masks(const Settings& settings) {
  const int images = settings.quick ? 4 : 20;
  const std::vector<Candidate> candidates = candidates_of(settings.quick);
  return work_of(
      candidates.size(),
      [candidates, images, seed = settings.seed](std::size_t k) {
        return measure_mask(candidates[k], images, seed + 1000 * k);
      },
      [candidates](const Errors& errors) { return masks_findings(candidates, errors); });
}

}  // namespace ovws::study
