/// Integrating control law.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mode_law.hpp"

namespace ovws {

/// Leaky integrator: c <- (1 - leak) c + gain r, with the residual r of the last frame and the
/// correction c in its hologram. As it counts from the correction shown, a limited or delayed
/// correction does not wind up.
class Integrator final : public ModeLaw {
 public:
  /// `gain`: 0 to 1; `leak`: 0 to below 1. Starts with `correction_waves`.
  Integrator(double gain, double leak, double correction_waves)
      : gain_(gain), leak_(leak), correction_waves_(correction_waves) {}

  void observe(const ModeSample& sample) override;
  double correction_at(std::int64_t) const override { return correction_waves_; }
  std::vector<std::complex<double>> transfer(std::span<const double> hz,
                                             double step_s) const override;

 private:
  double gain_, leak_;
  double correction_waves_;
};

}  // namespace ovws
