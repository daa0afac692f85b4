#include "core/spots/measured_model.hpp"

#include <utility>

#include "core/spots/wavefront_fit.hpp"

namespace ovws {
namespace {

constexpr double kMaxReferenceWaves = 0.03;  // RMS distance from the wavefront of the calibration
constexpr double kMaxMeasuredExcess = 0.15;  // weighted residual of a spot, fraction
constexpr double kMaxPositionErrorShare = 0.005;  // position error, fraction of a window's width

}  // namespace

Result<void> MeasuredModel::use_reference(const ImageView& image, const PixelNoise& noise) {
  const SpotPass pass = fit_spots(image, spots_, noise, estimates_);
  const auto step = step_from(pass);
  if (!step || step->waves.norm() > kMaxReferenceWaves) {
    return fail(Errc::refused, "reference",
                "the reference's wavefront is not that of the calibration: take a new reference, "
                "or calibrate again");
  }
  reference_waves_.assign(step->waves.begin(), step->waves.end());
  reference_levels_ = pass.levels_dn();
  return {};
}

Result<std::shared_ptr<const FrameFit>> MeasuredModel::templates(
    std::span<const ImageView> images) const {
  const PixelNoise noise = noise_of(images, spots_);
  const SpotPass pass = fit_spots(images.back(), spots_, noise, estimates_);
  OperatingPoint point;
  point.waves.assign(modes_j_.size(), 0.0);
  point.reference_waves = reference_waves_;
  point.noise = noise;
  point.levels_dn = pass.levels_dn();
  for (std::size_t i = 0; i < point.levels_dn.size(); ++i) {
    const bool lit = reference_levels_[i] > 0.0;
    if (!lit) point.levels_dn[i] = 0.0;
    point.lit += lit ? 1 : 0;
  }
  point.ceiling_dn = pass.ceiling_dn;
  point.estimates = estimates_;
  point.measured = true;
  point.max_excess = kMaxMeasuredExcess;
  auto fit = std::make_shared<FrameFit>(std::move(point), spots_, modes_j_);
  const SpotWindow& window = spots_.front().window;
  if (!fit->check(images.back(), kMaxPositionErrorShare * window.width_px()).credible) {
    return fail(Errc::refused, "image",
                "too few spots look as the calibration measured them: calibrate again");
  }
  return fit;
}

}  // namespace ovws
