/// The SLM's phase against its grey level, from beats of grey levels (grey_fringe.hpp), and the
/// look-up table that makes it linear.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <span>
#include <string>
#include <vector>

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
  std::array<double, 256> phase_rad{};  ///< of each grey level, 0 at grey 0, rising or falling
  std::array<double, 256> standard_error_rad{};  ///< of the difference from grey 0
  double noise_rad = 0.0;                        ///< RMS of one measured level
  double residual_rad = 0.0;                     ///< RMS of the measured levels about phase_rad
  bool falls() const { return phase_rad.back() < 0.0; }
  double depth_rad() const { return std::abs(phase_rad.back()); }
};

/// Fits the circle along which the beats run, takes the angles about its middle, counts whole turns
/// from level to level, and draws the smoothest curve through them that their noise allows.
/// Between measured levels the standard error grows. The phase is given as rising: a camera that
/// stands upside down sees the beats of a falling one alike; with_sign tells. Requires rising
/// greys, the first 0 and the last 255, 9 or more. Errors (Errc::refused): no circle, too much
/// noise, readings that differ by more than it (something moved), or a phase that turns back, with
/// the levels between which it does.
Result<PhaseResponse> phase_response(std::span<const GreyBeat> beats);

/// Grey levels to measure, too, before phase_response is asked: between neighbours whose phases are
/// more than a twenty-fourth of a turn apart, so many that evenly spaced ones would be no more;
/// none if the neighbours are close enough, or next to each other. Requires and Errors: as
/// phase_response, but of the circle and the noise only.
Result<std::vector<int>> levels_between(std::span<const GreyBeat> beats);

/// The light at the base spot of a grating blazed towards it by a table, seen twice.
struct BlazedLight {
  double first_dn = 0.0, second_dn = 0.0;
};

/// Of a response given as rising: what it is. With the right sign a blazed grating brings its light
/// to where the camera looks, with the wrong one to the other side of the zeroth order. `rising`:
/// under linearising_lut of the response, `falling`: under that of its negative. Errors
/// (Errc::refused): both are as bright, within 5 % or what the readings differ.
Result<PhaseResponse> with_sign(PhaseResponse response, const BlazedLight& rising,
                                const BlazedLight& falling);
/// phase_rad times -1.
std::array<double, 256> negative(std::array<double, 256> phase_rad);

/// Of a response, the table and what it lacks.
struct PhaseTable {
  PhaseLut lut{};
  int steps_out_of_reach = 0;  ///< of the 256: more than half a step beyond the nearer end
  std::string reason;          ///< for a person; empty if 2 pi is reached
};

/// Step k of 256 by the grey level whose phase is nearest to 2 pi k/256. With less than 2 pi a step
/// beyond the depth is shown by the last grey level or the first, whichever is nearer on the
/// circle. A phase that falls is as good as one that rises: the table then falls.
PhaseTable linearising_lut(const std::array<double, 256>& phase_rad);

}  // namespace ovws
