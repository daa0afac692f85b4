/// Zernike fit of a wavefront from a field, whose phase is known only modulo one wave (phase
/// unwrapping by modes).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/twin/pupil_blocks.hpp"

namespace ovws::twin {

struct WavefrontFit {
  /// Modes j = 0 .. 20 by least squares over the light, RMS-normalised waves; piston within half a
  /// wave.
  std::vector<Mode> modes;
  Eigen::VectorXd residual_waves;  ///< residual of each block, within half a wave
  /// Whether the modes explain the field, so that the residual needs no unwrapping: at most 1 % of
  /// the light deviates by more than 0.4 wave, and there are enough blocks to determine the modes.
  /// If false, the other fields are meaningless.
  bool unwrapped = false;
};

/// First fits the gradients between blocks (less than half a wave each: 48 waves across the pupil),
/// then repeatedly the residual phase, until the modes no longer change.
WavefrontFit fit_wavefront(const PupilBlocks& blocks, const Image<std::complex<float>>& field);

}  // namespace ovws::twin
