/// Integrating control law.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mode_law.hpp"

namespace ovws {

/// Leaky integrator: the next correction is (1 - leak) c + gain r, where r is the residual of the
/// last frame, and c the correction in the hologram of that frame. It starts from the correction
/// that was really shown, so a limited or delayed correction does not wind up.
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
