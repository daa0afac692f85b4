/// Zernike modes over the pupil circle: OSA/ANSI index, RMS-normalised unless stated otherwise.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws {

constexpr int kMaxZernikeIndex =
    230;  ///< n = 20, the highest order whose radial sums double precision resolves

struct ZernikeIndex {
  int n = 0;
  int m = 0;
};

enum class ZernikeNorm { rms, unit };  ///< unit: amplitude 1 at the pupil's edge

/// j = (n(n+2)+m)/2 (ANSI Z80.28). Requires n >= 0, |m| <= n, n-|m| even.
int osa_index(ZernikeIndex index);
/// The OSA index; none if (n, m) is not a mode or exceeds kMaxZernikeIndex.
std::optional<int> checked_osa_index(int n, int m);
ZernikeIndex zernike_index(int j);
/// "oblique astigmatism", "vertical coma", …; "Z(n,m)" for modes without a common name.
std::string zernike_name(int j);

/// RMS-normalised value = zernike_rms_factor(j) * unit-amplitude value: sqrt((2 - [m=0]) (n+1)).
double zernike_rms_factor(int j);

/// Coefficient of one mode, RMS-normalised waves.
struct Mode {
  int j = 0;
  double waves = 0.0;
  friend bool operator==(const Mode&, const Mode&) = default;
};

/// RMS-normalised Z_j at (x, y) in units of the pupil radius, x right, y down, theta from +x
/// towards +y.
double zernike(int j, Vec2 at);
/// Gradient of Z_j per pupil radius. Finite everywhere, including the centre.
Vec2 zernike_gradient(int j, Vec2 at);

/// Sum of modes at (x, y), waves, and its gradient, waves per pupil radius.
double wavefront(std::span<const Mode> modes, Vec2 at);
Vec2 wavefront_gradient(std::span<const Mode> modes, Vec2 at);

/// Number of modes without piston that M subapertures across resolve: floor(2.04 M^1.36), paper
/// eq. 5.
int optimal_mode_count(int subapertures_across);

}  // namespace ovws
