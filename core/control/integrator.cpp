#include "core/control/integrator.hpp"

#include <algorithm>

namespace ovws {

void Integrator::observe(const ModeSample& sample) {
  frames_ = std::min(frames_ + 1, kMostFrames);
  const double disturbance = sample.residual_waves + sample.shown_waves;
  disturbance_waves_ += (disturbance - disturbance_waves_) / frames_;
}

double Integrator::step(std::int64_t, double limit_waves) {
  if (frames_ > 0) {
    const double next = (1.0 - leak_ - gain_) * correction_waves_ + gain_ * disturbance_waves_;
    correction_waves_ = std::clamp(next, -limit_waves, limit_waves);
  }
  frames_ = 0;
  return correction_waves_;
}

std::vector<std::complex<double>> Integrator::transfer(std::span<const double> hz,
                                                       const LoopTiming& timing) const {
  std::vector<std::complex<double>> found;
  for (const double at : hz) {
    found.push_back(gain_ * delayed(at, timing.delay_s) /
                    (1.0 - (1.0 - leak_ - gain_) * delayed(at, timing.step_s)));
  }
  return found;
}

}  // namespace ovws
