#include "core/optics/sensor_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/optics/phasors.hpp"

namespace ovws {

Result<SensorModel> SensorModel::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                      const OpticsConfig& optics, int cols, int rows) {
  if (auto straight = check_straight(optics, slm); !straight) return fail(straight.error());
  HologramConfig hologram;
  hologram.slm = slm;
  hologram.sensor = sensor;
  auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  SensorModel model(std::move(*renderer),
                    FarField(slm, far_field_window(sensor, slm, optics, cols, rows)));
  model.spots_px_ = model_spots_px(model.lattice(), sensor, slm, optics, cols, rows);
  model.lambda_d_px_ = ovws::lambda_d_px(optics, slm, sensor);
  model.pupil_radius_px_ = 0.5 * sensor.pupil_diameter_px;
  model.px_per_cycle_ = camera_px_per_cycle(optics, slm);
  return model;
}

Result<Image<float>> SensorModel::intensity(std::span<const Mode> modes) {
  if (auto sampled = renderer_.check_sampling(modes); !sampled) return fail(sampled.error());
  renderer_.render(HologramKind::sensor, modes, grey_);
  field_.width = grey_.width;
  field_.height = grey_.height;
  field_.pixels.resize(grey_.pixels.size());
  std::transform(grey_.pixels.begin(), grey_.pixels.end(), field_.pixels.begin(),
                 [](std::uint8_t level) { return unit_phasors()[std::size_t{level} << 8]; });
  far_field_.propagate(field_, far_);
  Image<float> result(far_.width, far_.height);
  std::transform(far_.pixels.begin(), far_.pixels.end(), result.pixels.begin(),
                 [](std::complex<float> value) { return std::norm(value); });
  return result;
}

double SensorModel::peak_of_spots(const Image<float>& intensity,
                                  std::span<const Mode> modes) const {
  float peak = 0.0F;
  const int reach = int(std::ceil(2.0 * lambda_d_px_));
  for (std::size_t i = 0; i < spots_px_.size(); ++i) {
    const Vec2 at = (1.0 / pupil_radius_px_) * lattice().subapertures[i].centre_px;
    const Vec2 slope = (1.0 / pupil_radius_px_) * wavefront_gradient(modes, at);
    const Vec2 spot = spots_px_[i] + px_per_cycle_ * slope;
    const int left = std::max(0, int(spot.x) - reach);
    const int right = std::min(intensity.width, int(spot.x) + reach + 1);
    const int bottom = std::min(intensity.height, int(spot.y) + reach + 1);
    for (int y = std::max(0, int(spot.y) - reach); y < bottom; ++y) {
      for (int x = left; x < right; ++x) peak = std::max(peak, intensity.at(x, y));
    }
  }
  return double(peak);
}

void scale(Image<float>& intensity, double factor) {
  for (float& pixel : intensity.pixels) pixel = float(pixel * factor);
}

double total(const Image<float>& intensity) {
  return std::accumulate(intensity.pixels.begin(), intensity.pixels.end(), 0.0);
}

}  // namespace ovws
