/// Integrating control law.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/control/mode_law.hpp"

namespace ovws {

/// Leaky integrator of the disturbance (pseudo open-loop control; Piatrou and Gilles, Applied
/// Optics 44, 1003, 2005). A step changes the correction c to (1 - leak - gain) c + gain d. The
/// disturbance d is residual plus shown correction, averaged over the frames since the last step
/// with growing weights, as if each frame had a step of its own (without leak): with the gain 1 the
/// newest frame counts alone. If the next frame has the correction, that is (1 - leak) c + gain r
/// with its residual r. The shown correction cancels in d, so the loop is stable with any delay of
/// the correction.
class Integrator final : public ModeLaw {
 public:
  /// `gain`: 0 to 1; `leak`: 0 to below 1. Starts with `correction_waves`.
  Integrator(double gain, double leak, double correction_waves)
      : gain_(gain), leak_(leak), correction_waves_(correction_waves) {}

  void observe(const ModeSample& sample) override;
  double step(std::int64_t t_ns, double limit_waves) override;
  /// Number of frames that the weights of `frames` frames amount to: their mean has the noise of so
  /// many frames with equal weights. 1 for the gain 1, `frames` for small gains.
  static double counted_frames(double gain, double frames);
  /// gain z^-d / (1 - (1 - leak - gain) / z), with the delay d in steps.
  std::vector<std::complex<double>> transfer(std::span<const double> hz,
                                             const LoopTiming& timing) const override;

 private:
  static constexpr std::size_t kMostFrames = 16;
  double recent_disturbance_waves() const;

  double gain_, leak_;
  double correction_waves_;
  std::array<double, kMostFrames> disturbance_waves_{};  ///< of the newest frames, in a ring
  std::size_t frames_ = 0;                               ///< since the last step
};

}  // namespace ovws
