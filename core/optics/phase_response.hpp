/// The SLM's phase against its grey level, from beats of grey levels (grey_fringe.hpp), and the
/// look-up table that makes it linear.
#pragma once

#include <array>
#include <complex>
#include <span>
#include <string>

#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {

/// The beat of one grey level, seen twice, some time apart: what differs is noise and drift.
struct GreyBeat {
  int grey = 0;
  std::complex<double> first, second;
};

struct PhaseResponse {
  int levels = 0;                       ///< measured
  std::array<double, 256> phase_rad{};  ///< of each grey level, 0 at grey 0, rising
  std::array<double, 256> standard_error_rad{};
  double noise_rad = 0.0;     ///< RMS of one measured level
  double residual_rad = 0.0;  ///< RMS of the measured levels about phase_rad
  double depth_rad() const { return phase_rad.back(); }
};

/// Fits the circle along which the beats run, takes the angles about its middle, counts whole turns
/// from level to level, and draws the smoothest curve through them that their noise allows.
/// Between measured levels the standard error grows. Phase counts in the direction in which grey
/// raises it. Requires rising greys, the first 0 and the last 255, 9 or more. Errors
/// (Errc::refused): no circle, too much noise, or a phase that falls, with the levels between which
/// it does.
Result<PhaseResponse> phase_response(std::span<const GreyBeat> beats);

/// Of a response, the table and what it lacks.
struct PhaseTable {
  PhaseLut lut{};
  int steps_out_of_reach = 0;  ///< of the 256: more than half a step beyond the nearer end
  std::string reason;          ///< for a person; empty if 2 pi is reached
};

/// Step k of 256 by the grey level whose phase is nearest to 2 pi k/256. With less than 2 pi a step
/// beyond the depth is shown by the last grey level or the first, whichever is nearer on the
/// circle.
PhaseTable linearising_lut(const std::array<double, 256>& phase_rad);

}  // namespace ovws
