#include "tests/unit/tracking/sensor_image.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace ovws::test {
namespace {

constexpr int kImage = 512;

SensorConfig sensor_of(int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  return sensor;
}

HologramConfig hologram_of(int charge) {
  HologramConfig config;
  config.sensor = sensor_of(charge);
  return config;
}

}  // namespace

SensorBench::SensorBench(int charge)
    : sensor(sensor_of(charge)),
      lattice(make_lattice(sensor, slm).value()),
      model_px(model_spots_px(lattice, sensor, slm, optics, kImage, kImage)),
      lambda_d(lambda_d_px(optics, slm, sensor)),
      px_per_cycle(camera_px_per_cycle(optics, slm)),
      renderer_(HologramRenderer::make(hologram_of(charge)).value()),
      far_field_(slm, far_field_window(sensor, slm, optics, kImage, kImage)) {
  const Image<float> flat = propagate({}, {});
  unit_ = double(*std::max_element(flat.pixels.begin(), flat.pixels.end()));
}

Image<float> SensorBench::light(std::span<const Mode> modes, const std::vector<int>& dark) {
  Image<float> image = propagate(modes, dark);
  for (float& pixel : image.pixels) pixel /= float(unit_);
  return image;
}

Image<float> SensorBench::propagate(std::span<const Mode> modes, const std::vector<int>& dark) {
  Image<std::uint8_t> grey(slm.width_px, slm.height_px);
  renderer_.render(HologramKind::sensor, modes, grey);
  Image<std::complex<float>> field(slm.width_px, slm.height_px);
  for (std::size_t k = 0; k < grey.pixels.size(); ++k) {
    field.pixels[k] = std::polar(1.0F, float(2.0 * std::numbers::pi * grey.pixels[k] / 256.0));
  }
  for (const int i : dark) {
    const Vec2 centre = lattice.subapertures[i].centre_px;
    for (int y = 0; y < slm.height_px; ++y) {
      for (int x = 0; x < slm.width_px; ++x) {
        const Vec2 at{x - 0.5 * (slm.width_px - 1), y - 0.5 * (slm.height_px - 1)};
        if (norm(at - centre) < 0.5 * lattice.diameter_px) field.at(x, y) = 0.0F;
      }
    }
  }
  Image<std::complex<float>> far(kImage, kImage);
  far_field_.propagate(field, far);
  Image<float> image(kImage, kImage);
  for (std::size_t k = 0; k < far.pixels.size(); ++k) image.pixels[k] = std::norm(far.pixels[k]);
  return image;
}

SensorBench& sensor_bench(int charge) {
  static std::map<int, SensorBench> benches;
  return benches.try_emplace(charge, charge).first->second;
}

Image<std::uint8_t> expose8(const Image<float>& light, double peak_dn, double noise_dn,
                            double black_dn, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  Image<std::uint8_t> out(light.width, light.height);
  for (std::size_t k = 0; k < out.pixels.size(); ++k) {
    const double electronic = noise_dn > 0.0 ? noise_dn * noise(random) : 0.0;
    const double dn = peak_dn * double(light.pixels[k]) + black_dn + electronic;
    out.pixels[k] = std::uint8_t(std::clamp(std::round(dn), 0.0, 255.0));
  }
  return out;
}

}  // namespace ovws::test
