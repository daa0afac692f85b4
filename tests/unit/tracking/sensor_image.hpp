/// Simulated camera images of the real hologram: core/optics from modes to intensity, then
/// rounding.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"

namespace ovws::test {

/// The default bench with one sensor on it, camera 512 x 512.
class SensorBench {
 public:
  explicit SensorBench(int charge);

  /// Intensity with these modes shown; 1 is the brightest pixel of the flat sensor's image.
  /// Subapertures in `dark` are switched off.
  Image<float> light(std::span<const Mode> modes, const std::vector<int>& dark = {});

  int subapertures() const { return int(lattice.subapertures.size()); }

  SensorConfig sensor;
  SlmGeometry slm;
  OpticsConfig optics;
  Lattice lattice;
  std::vector<Vec2> model_px;
  double lambda_d = 0.0;
  double px_per_cycle = 0.0;

 private:
  Image<float> propagate(std::span<const Mode> modes, const std::vector<int>& dark);

  HologramRenderer renderer_;
  FarField far_field_;
  double unit_ = 1.0;
};

/// One bench per charge for the whole program: making one takes longer than most tests.
SensorBench& sensor_bench(int charge);

/// round(peak_dn * light + black_dn + noise), clipped to 8 bit; reproducible for a seed.
Image<std::uint8_t> expose8(const Image<float>& light, double peak_dn, double noise_dn = 0.0,
                            double black_dn = 0.0, unsigned seed = 1);

}  // namespace ovws::test
