#include "daemon/ovws/study/fitting.hpp"

#include <cmath>

#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {
namespace {

constexpr double kMaxStepWaves = 0.4;  // RMS; a longer step leaves the derivatives' valid range

}  // namespace

SpotRenderer renderer_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j,
                         const SpotRenderer::Options& options) {
  SensorConfig sensor = geometry.sensor;
  sensor.charge = charge;
  return value_of(SpotRenderer::make(sensor, geometry.slm, geometry.optics, kImagePx, kImagePx,
                                     modes_j, options));
}

PixelNoise noise_of(const Exposure& exposure, double read_noise_e) {
  constexpr double kRoundingDn2 = 1.0 / 12.0;
  const double read_noise_dn = read_noise_e * exposure.dn_per_e;
  return {read_noise_dn * read_noise_dn + kRoundingDn2, exposure.dn_per_e};
}

std::vector<double> fitted_waves(SpotRenderer& renderer, const Exposure& exposure,
                                 double read_noise_e, std::vector<double> start, int renderings) {
  const PixelNoise noise = noise_of(exposure, read_noise_e);
  std::vector<double> waves = std::move(start);
  const std::vector<double> none(waves.size(), kUnknown);
  if (std::isnan(waves.front())) return none;
  for (int k = 0; k < renderings; ++k) {
    const auto rendered = renderer.render(waves);
    const auto step = damped_step(fit_spots(exposure.view(), rendered, noise, kMaxSpotEstimates));
    if (!step) return none;
    const double damping = std::min(1.0, kMaxStepWaves / step->waves.norm());
    for (std::size_t j = 0; j < waves.size(); ++j) {
      waves[j] += damping * step->waves(Eigen::Index(j));
    }
  }
  return waves;
}

}  // namespace ovws::study
