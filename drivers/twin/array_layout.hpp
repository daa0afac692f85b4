/// Geometry of a lenslet array: where the lenslets are, what a lenslet covers, and the phase of its
/// spiral plate. Lengths are in micrometres in the array's plane, x right and y down.
#pragma once

#include <vector>

#include "core/base/vec2.hpp"
#include "drivers/twin/array_config.hpp"

namespace ovws::twin {

/// Centres of the lenslets from the array's centre, row by row. A square lattice is centred; on a
/// hexagonal lattice every other row, but not the middle one, is half a pitch to the right.
std::vector<Vec2> lenslet_centres(const ArrayConfig& array);

/// Whether a position relative to a lenslet's centre belongs to this lenslet.
bool in_lenslet(const ArrayConfig& array, Vec2 from_centre_um);

/// Area of a lenslet, square micrometres.
double lenslet_area(const ArrayConfig& array);

/// Phase of the spiral plate at a position relative to the lenslet's centre, radians.
double plate_radians(const PlateConfig& plate, int charge, Vec2 from_centre_um);

}  // namespace ovws::twin
