/// Zernike fit of a wavefront to a complex field: phase unwrapping by modes, because the field's
/// phase is known only modulo one wave.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/twin/pupil_blocks.hpp"

namespace ovws::twin {

struct WavefrontFit {
  /// Zernike modes j = 0 .. 20, RMS-normalised waves; least-squares fit weighted by the amplitude.
  /// The piston is within half a wave.
  std::vector<Mode> modes;
  Eigen::VectorXd residual_waves;  ///< residual of each block, within half a wave
  /// Whether the modes explain the field, so that the residual needs no unwrapping. True if at most
  /// 1 % of the light deviates by more than 0.4 wave and the blocks determine all modes. If false,
  /// the modes and the residual are meaningless.
  bool unwrapped = false;
};

/// Fits the Zernike modes in two stages: first to the gradients between blocks (each below half a
/// wave, so up to 48 waves across the pupil), then to the residual phase until the modes converge.
WavefrontFit fit_wavefront(const PupilBlocks& blocks, const Image<std::complex<float>>& field);

}  // namespace ovws::twin
