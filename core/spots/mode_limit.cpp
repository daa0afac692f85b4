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

}  // namespace

Result<ModeErrors> mode_errors(const ModeBench& bench, int modes) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<int> modes_j(static_cast<std::size_t>(modes));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  auto renderer = SpotRenderer::make(bench.sensor, bench.slm, bench.optics, bench.cols, bench.rows,
                                     std::move(modes_j), {.lit = bench.lit});
  if (!renderer) return fail(renderer.error());
  const std::vector<RenderedSpot> spots =
      renderer->render(std::vector<double>(static_cast<std::size_t>(modes)));
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

Result<ModeErrors> most_modes(const ModeBench& bench, int below) {
  auto most = mode_errors(bench, 1);
  for (int above = below; most && most->modes < above;) {
    auto middle = mode_errors(bench, (most->modes + above + 1) / 2);
    if (!middle) return middle;
    if (middle->are_determined()) {
      most = middle;
    } else {
      above = middle->modes - 1;
    }
  }
  return most;
}

}  // namespace ovws
