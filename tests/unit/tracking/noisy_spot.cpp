#include "tests/unit/tracking/noisy_spot.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/optics/noise.hpp"

namespace ovws::test {

Image<float> mean_electrons(const ModelShape& shape, Vec2 at) {
  Image<float> image(kNoisySide, kNoisySide);
  for (int y = 0; y < kNoisySide; ++y) {
    for (int x = 0; x < kNoisySide; ++x) {
      image.at(x, y) = float(kNoisyPeak * shape.at(Vec2{double(x), double(y)} - at).value);
    }
  }
  return image;
}

double bound_px(const ModelShape& shape, Vec2 at, double read_noise_e) {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  for (int y = 0; y < kNoisySide; ++y) {
    for (int x = 0; x < kNoisySide; ++x) {
      const ShapeSample s = shape.at(Vec2{double(x), double(y)} - at);
      const Eigen::Vector4d slope = kNoisyPeak * Eigen::Vector4d(s.dx, s.dy, s.value, 1.0);
      const double mean = kNoisyPeak * std::max(s.value, 0.0);
      information += slope * slope.transpose() / (mean + read_noise_e * read_noise_e);
    }
  }
  const Eigen::Matrix4d covariance = information.inverse();
  return std::sqrt(0.5 * (covariance(0, 0) + covariance(1, 1)));
}

double read_noise_of(double snr) {
  return std::sqrt(kNoisyPeak * kNoisyPeak / (snr * snr) - kNoisyPeak);
}

Image<std::uint16_t> expose12(const Image<float>& electrons, double read_noise_e,
                              std::uint64_t seed) {
  Noise noise(seed, 1);
  const double black = std::ceil(4.5 * read_noise_e) + 20.0;
  Image<std::uint16_t> out(electrons.width, electrons.height);
  for (std::size_t k = 0; k < out.pixels.size(); ++k) {
    const double dn =
        double(noise.poisson(electrons.pixels[k])) + read_noise_e * double(noise.normal()) + black;
    out.pixels[k] = std::uint16_t(std::clamp(std::round(dn), 0.0, 4095.0));
  }
  return out;
}

}  // namespace ovws::test
