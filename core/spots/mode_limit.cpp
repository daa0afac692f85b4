#include "core/spots/mode_limit.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/decompositions.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/spots/spot_templates.hpp"

namespace ovws {
namespace {

constexpr int kTilts = 2;                // tip and tilt are the first modes
constexpr double kConditioning = 1e-12;  // least rcond at which the modes are determined

/// The spots of a flat wavefront, with their derivatives for modes j = 1 to `modes`.
Result<std::vector<RenderedSpot>> rendered(const ModeBench& bench, int modes) {
  std::vector<int> modes_j(static_cast<std::size_t>(modes));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  auto renderer = SpotRenderer::make(bench.sensor, bench.slm, bench.optics, bench.cols, bench.rows,
                                     std::move(modes_j), {.lit = bench.lit});
  if (!renderer) return fail(renderer.error());
  return renderer->render(std::vector<double>(static_cast<std::size_t>(modes)));
}

ModeErrors errors_of(const ModeBench& bench, const std::vector<RenderedSpot>& spots) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const auto modes = int(spots.front().per_wave.cols());
  const int pixels = spots.front().window.bin * spots.front().window.bin;
  const std::vector<CellLevel> levels(spots.size(), CellLevel{bench.peak_e * pixels});
  double light = 0.0;
  for (const RenderedSpot& spot : spots) light += pixels * double(spot.light.sum());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(modes, modes);
  for (const SpotTemplates& spot : make_templates(
           spots, levels, {bench.read_noise_e * bench.read_noise_e, 1.0}, bench.estimates)) {
    if (spot.estimates() == 0) continue;
    const Eigen::MatrixXd rows = bench.peak_e * pixels * spot.per_wave;
    normal.noalias() += rows.transpose() * rows;
  }
  const Cholesky factors(normal);
  if (!(factors.reciprocal_condition() > kConditioning)) {
    return ModeErrors{modes, kNever, kNever, 0.0, light};
  }
  const Eigen::VectorXd variances = factors.inverse().diagonal();
  return ModeErrors{modes, std::sqrt(variances.tail(std::max(modes - kTilts, 0)).sum()),
                    std::sqrt(variances.maxCoeff()), 1.0 / std::sqrt(normal(0, 0)), light};
}

/// The same spots with the derivatives of the first modes only.
std::vector<RenderedSpot> with_modes(std::vector<RenderedSpot> spots, int modes) {
  for (RenderedSpot& spot : spots) spot.per_wave = spot.per_wave.leftCols(modes).eval();
  return spots;
}

}  // namespace

Result<ModeErrors> mode_errors(const ModeBench& bench, int modes) {
  const auto spots = rendered(bench, modes);
  if (!spots) return fail(spots.error());
  return errors_of(bench, *spots);
}

Result<ModeErrors> most_modes(const ModeBench& bench, int below) {
  const auto spots = rendered(bench, below);
  if (!spots) return fail(spots.error());
  ModeErrors most = errors_of(bench, with_modes(*spots, 1));
  for (int above = below; most.modes < above;) {
    const ModeErrors middle = errors_of(bench, with_modes(*spots, (most.modes + above + 1) / 2));
    if (middle.are_determined()) {
      most = middle;
    } else {
      above = middle.modes - 1;
    }
  }
  return most;
}

}  // namespace ovws
