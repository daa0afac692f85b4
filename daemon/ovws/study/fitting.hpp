/// Fits templates of every spot to a simulated exposure, as the daemon's `fit` does; the
/// Cramer-Rao bound of such a fit; and the search for the spots of one image without history, as
/// the daemon does after a sudden change.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/point_model.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/tracking/acquisition.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Makes a SpotRenderer for the study's image size and the modes `modes_j`. Not thread-safe.
SpotRenderer renderer_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j,
                         const SpotRenderer::Options& options = {});

/// The noise of an exposure's pixels, DN.
PixelNoise noise_of(const Exposure& exposure, double read_noise_e);

/// Fits the modes in `renderings` damped steps from `start`. Returns coefficients in waves, in the
/// order of the renderer's modes. All are NaN if the spots do not determine the modes, or if
/// `start` is NaN.
std::vector<double> fitted_waves(SpotRenderer& renderer, const Exposure& exposure,
                                 double read_noise_e, std::vector<double> start, int renderings);

/// Makes a renderer whose windows do not overlap and hold nearly all of each spot's intensity.
SpotRenderer bound_renderer_of(const Geometry& geometry, int charge,
                               const std::vector<int>& modes_j);

/// Cramer-Rao bound: inverse Fisher matrix of the renderer's modes at the wavefront `modes`,
/// waves^2. One amplitude and one background, common to all spots, are further unknowns. `light_e`:
/// the noise-free image of this wavefront, electrons. No unbiased estimate of the modes has smaller
/// errors. NaN if the image does not determine the modes.
Eigen::MatrixXd pixel_covariance(SpotRenderer& renderer, std::span<const Mode> modes,
                                 const Image<float>& light_e, double read_noise_e);

/// Cramer-Rao bound of the residual variance, rad^2: trace of pixel_covariance for all modes that
/// spot positions determine.
double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e);

/// Search without history: Acquisition finds the spots' positions. The tracker `fit` then fits all
/// pixels (PointModel), starting at the wavefront from the positions, then at a flat one. Not
/// thread-safe.
class Searcher {
 public:
  /// `measurer` must outlive it.
  Searcher(const Geometry& geometry, const Measurer& measurer);

  /// Finds a fix of each spot. If `fit` finds no wavefront, all spots are lost.
  std::vector<SpotFix> find(const Exposure& exposure, double read_noise_e);

 private:
  std::vector<SpotFix> fitted(const Exposure& exposure, double read_noise_e,
                              const std::vector<SpotFix>& by_positions);

  const Measurer& measurer_;
  Acquisition acquisition_;
  TrackScratch scratch_;
  std::optional<PointModel> model_;
};

}  // namespace ovws::study
