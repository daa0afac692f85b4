/// The wavefront of light whose phase is known only modulo one wave.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/twin/pupil_blocks.hpp"

namespace ovws::twin {

struct WavefrontFit {
  /// Modes j = 0 .. 20 by least squares over the light, RMS-normalised waves; piston within half a
  /// wave.
  std::vector<Mode> modes;
  Eigen::VectorXd rest_waves;  ///< what the modes leave, by block; within half a wave
  /// Whether the modes explain the light, so that the rest needs no unwrapping: at most 1 % of the
  /// light is more than 0.4 wave off, and there are blocks enough to tell the modes. If not,
  /// nothing of the above means anything.
  bool unwrapped = false;
};

/// Gradients from block to block first (less than half a wave each: 48 waves across the pupil),
/// then the phase that each fit leaves, until nothing changes.
WavefrontFit fit_wavefront(const PupilBlocks& blocks, const Image<std::complex<float>>& field);

}  // namespace ovws::twin
