#include "core/control/integrator.hpp"

#include <numbers>

namespace ovws {

void Integrator::observe(const ModeSample& sample) {
  correction_waves_ = (1.0 - leak_) * sample.shown_waves + gain_ * sample.residual_waves;
}

std::vector<std::complex<double>> Integrator::transfer(std::span<const double> hz,
                                                       double step_s) const {
  std::vector<std::complex<double>> found;
  for (const double at : hz) {
    const auto z = std::polar(1.0, 2.0 * std::numbers::pi * at * step_s);
    found.push_back(gain_ / (z - (1.0 - leak_ - gain_)));
  }
  return found;
}

}  // namespace ovws
