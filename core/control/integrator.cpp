#include "core/control/integrator.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {

void Integrator::observe(const ModeSample& sample) {
  disturbance_waves_[frames_++ % kMostFrames] = sample.residual_waves + sample.shown_waves;
}

double Integrator::recent_disturbance_waves() const {
  const std::size_t count = std::min(frames_, kMostFrames);
  const double kept = std::pow(1.0 - gain_, 1.0 / double(count));
  double sum = 0.0, weights = 0.0, weight = 1.0;
  for (std::size_t k = 1; k <= count; ++k, weight *= kept) {
    sum += weight * disturbance_waves_[(frames_ - k) % kMostFrames];
    weights += weight;
  }
  return sum / weights;
}

double Integrator::counted_frames(double gain, double frames) {
  const double kept = std::pow(1.0 - gain, 1.0 / frames);
  if (kept >= 1.0) return frames;
  // Sum of the weights, squared, over the sum of their squares; both are geometric series.
  const double all = std::pow(kept, frames);
  return (1.0 - all) * (1.0 + kept) / ((1.0 + all) * (1.0 - kept));
}

double Integrator::step(std::int64_t, double limit_waves) {
  if (frames_ > 0) {
    const double next =
        (1.0 - leak_ - gain_) * correction_waves_ + gain_ * recent_disturbance_waves();
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
