/// SLM phase response: phase against grey level, from fringe measurements (grey_fringe.hpp), and
/// the look-up table that linearises it. HologramRenderer applies the table.
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

/// Complex fringe amplitude of one grey level, measured twice: the difference is noise and drift.
struct GreyBeat {
  int grey = 0;
  std::complex<double> first, second;
};

struct PhaseResponse {
  int levels = 0;                                ///< number of measured grey levels
  std::array<double, 256> phase_rad{};           ///< by grey level, 0 at grey 0, rising or falling
  std::array<double, 256> standard_error_rad{};  ///< of the difference from grey 0
  double noise_rad = 0.0;                        ///< RMS noise of one measured level
  double residual_rad = 0.0;                     ///< RMS of measured levels minus phase_rad
  bool falls() const { return phase_rad.back() < 0.0; }
  double depth_rad() const { return std::abs(phase_rad.back()); }
};

/// Computes the phase response: fits a circle to the beats, unwraps the angles about its centre,
/// and smooths them as much as their noise allows. The standard error grows between measured
/// levels. The result always rises, because a camera mounted upside down sees the same beats for a
/// falling response; with_sign resolves this. Requires 9 or more ascending grey levels, the first 0
/// and the last 255. Errors (Errc::refused): no circle, too much noise, drift between the readings,
/// a phase that is not monotonic (the reason names the levels), or a range below 1 rad.
Result<PhaseResponse> phase_response(std::span<const GreyBeat> beats);

/// Adaptive sampling: the grey levels to measure in addition before phase_response. Subdivides each
/// interval whose phase step exceeds 1/24 turn into the fewest equal parts that do not exceed it.
/// Empty if no interval needs it or can be divided. Requires the same as phase_response; errors:
/// its errors about circle, noise and drift.
Result<std::vector<int>> levels_between(std::span<const GreyBeat> beats);

/// Intensity at the base spot with a grating blazed by a LUT, measured twice.
struct BlazedLight {
  double first_dn = 0.0, second_dn = 0.0;
};

/// Resolves the sign of a rising response. With the correct sign a blazed grating diffracts into
/// the camera's field, with the wrong one to the other side of the zeroth order. `rising` is
/// measured with linearising_lut of the response, `falling` with that of its negative. Errors
/// (Errc::refused): the two differ by no more than 5 % or three times the difference between
/// repeated readings.
Result<PhaseResponse> with_sign(PhaseResponse response, const BlazedLight& rising,
                                const BlazedLight& falling);
/// phase_rad times -1.
std::array<double, 256> negative(std::array<double, 256> phase_rad);

/// The linearising LUT of a response, and the phases that it cannot reach.
struct PhaseTable {
  PhaseLut lut{};
  int steps_out_of_reach = 0;  ///< steps more than half a step beyond the nearer end
  std::string reason;          ///< message about unreachable phases; empty if there are none
};

/// Inverts the response: step k gets the grey level whose phase is closest to 2 pi k/256. If the
/// range is below 2 pi, a step beyond it gets the last or the first grey level, whichever is closer
/// modulo 2 pi. A falling response gives a falling table.
PhaseTable linearising_lut(const std::array<double, 256>& phase_rad);

}  // namespace ovws
