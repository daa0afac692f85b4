/// SLM phase response: phase against grey level, from fringe measurements (grey_fringe.hpp). Also
/// computes the look-up table that makes the phase linear; HologramRenderer applies this table.
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

/// Complex fringe amplitude ("beat") of one grey level, measured twice. The difference between the
/// two readings shows noise and drift.
struct GreyBeat {
  int grey = 0;
  std::complex<double> first, second;
};

struct PhaseResponse {
  int levels = 0;                                ///< number of measured grey levels
  std::array<double, 256> phase_rad{};           ///< by grey level, 0 at grey 0, rising or falling
  std::array<double, 256> standard_error_rad{};  ///< of the phase difference from grey 0
  double noise_rad = 0.0;                        ///< RMS noise of one measured level
  double residual_rad = 0.0;                     ///< RMS of measured levels minus phase_rad
  bool falls() const { return phase_rad.back() < 0.0; }
  double depth_rad() const { return std::abs(phase_rad.back()); }
};

/// Computes the phase response: fits a circle to the beats, unwraps the angles about its centre and
/// smooths the phases as far as their noise allows. The standard error grows between measured
/// levels. The result always rises, because the beats do not give the sign of the phase; call
/// with_sign to find it. Requires 9 or more ascending grey levels, the first 0 and the last 255.
/// Errors (Errc::refused): the beats lie on no circle, too much noise, drift between the readings,
/// a phase that is not monotonic (the reason names the levels), or a range below 1 rad.
Result<PhaseResponse> phase_response(std::span<const GreyBeat> beats);

/// Adaptive sampling: returns the grey levels to measure in addition before phase_response. Divides
/// each interval whose phase step exceeds 1/24 turn into the fewest equal parts of at most 1/24
/// turn. Empty if no interval must or can be divided. Has the requirements of phase_response and
/// its errors about circle, noise and drift.
Result<std::vector<int>> levels_between(std::span<const GreyBeat> beats);

/// Intensity at the base spot, measured twice, while the SLM shows a grating blazed by a LUT.
struct BlazedLight {
  double first_dn = 0.0, second_dn = 0.0;
};

/// Resolves the sign of a phase response. With the correct sign a blazed grating diffracts into the
/// camera's field, with the wrong sign to the other side of the zeroth order. Measure `rising` with
/// linearising_lut of the response, and `falling` with linearising_lut of its negative.
/// Errc::refused unless these intensities differ by more than 5 % and by more than three times the
/// difference between repeated readings.
Result<PhaseResponse> with_sign(PhaseResponse response, const BlazedLight& rising,
                                const BlazedLight& falling);
/// Phase response with the opposite sign: phase_rad times -1.
std::array<double, 256> negative(std::array<double, 256> phase_rad);

/// Linearising look-up table (LUT) of a phase response, and the phases that the SLM cannot reach.
struct PhaseTable {
  PhaseLut lut{};
  int steps_out_of_reach = 0;  ///< phase steps missed by more than half a step
  std::string reason;          ///< message about unreachable phases; empty if there are none
};

/// Computes the linearising LUT: step k gets the grey level whose phase is closest to 2 pi k/256. A
/// step beyond the SLM's phase range gets grey level 255 or 0, whichever is closer modulo 2 pi. If
/// the phase falls with the grey level, the grey levels fall with the step.
PhaseTable linearising_lut(const std::array<double, 256>& phase_rad);

}  // namespace ovws
