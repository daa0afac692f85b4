/// Zernike modes over the pupil circle: OSA/ANSI index, RMS-normalised unless stated otherwise.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws {

constexpr int kMaxZernikeIndex =
    230;  ///< n = 20: radial sums of higher orders need more than double precision

struct ZernikeIndex {
  int n = 0;
  int m = 0;
};

enum class ZernikeNorm { rms, unit };  ///< unit: amplitude 1 at the pupil's edge

/// OSA/ANSI index j = (n(n+2)+m)/2 (ANSI Z80.28). Requires n >= 0, |m| <= n, n-|m| even.
int osa_index(ZernikeIndex index);
/// OSA/ANSI index; none if (n, m) is not a mode or the index exceeds kMaxZernikeIndex.
std::optional<int> checked_osa_index(int n, int m);
ZernikeIndex zernike_index(int j);
/// Name of a mode: "oblique astigmatism", "vertical coma", …; "Z(n,m)" if it has no common name.
std::string zernike_name(int j);

/// RMS factor: ratio of the RMS-normalised to the unit-amplitude mode, sqrt((2 - [m=0]) (n+1)).
double zernike_rms_factor(int j);

/// Coefficient of one mode, RMS-normalised waves.
struct Mode {
  int j = 0;
  double waves = 0.0;
  friend bool operator==(const Mode&, const Mode&) = default;
};

/// Adds `mode` to a list, to the coefficient that the list has of it, if any.
void add_mode(std::vector<Mode>& modes, const Mode& mode);

/// RMS-normalised Zernike mode Z_j at position `at` in pupil radii: x right, y down, theta from +x
/// towards +y.
double zernike(int j, Vec2 at);
/// Z_0, Z_1, … at one position, as many as `values` has; faster than one by one, with equal
/// results.
void zernike_values(Vec2 at, std::span<double> values);
/// Gradient of the RMS-normalised mode Z_j per pupil radius. Finite everywhere, also at the centre.
Vec2 zernike_gradient(int j, Vec2 at);

/// Wavefront in waves at position `at` (pupil radii), the sum of `modes`. Its gradient is in waves
/// per pupil radius.
double wavefront(std::span<const Mode> modes, Vec2 at);
Vec2 wavefront_gradient(std::span<const Mode> modes, Vec2 at);

/// Optimal number of modes (without piston) to reconstruct with M subapertures across the pupil:
/// floor(2.04 M^1.36), paper eq. 5.
int optimal_mode_count(int subapertures_across);

}  // namespace ovws
