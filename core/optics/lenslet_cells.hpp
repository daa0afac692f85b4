/// Complex field on a lenslet array for a flat wavefront, and the far field of one lenslet.
#pragma once

#include <complex>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/pupil_cells.hpp"

namespace ovws {

/// Cuts the lenslets of `sensor` into cells, kLensletCells across a lenslet. The value of a cell is
/// the share of it that the lenslet covers, with the phase of the spiral plate and of the lenslet's
/// grating at the cell's centre. There is no light outside of the lenslets in use. `turn`: how the
/// camera sees the array; its scale is ignored.
PupilCells cut_lenslets(const SensorConfig& sensor, const PxPerCycle& turn);
constexpr int kLensletCells = 128;

/// Adds the far field of one lenslet to the pixels of `far` within four pitches and a half of its
/// centre. With 5 x 5 lenslets a spot then agrees with Fresnel's integral within 1 % of its peak
/// (0.15 % RMS) if it is bright, and within 3.5 % (0.8 % RMS) if it is a vortex, whose neighbours'
/// light reaches far. `width_px`: the pitch; `runs`: its cells; `pupil`: the field, as
/// SensorField::pupil().
void add_lenslet(const PupilCells& cells, double width_px, std::span<const CellRun> runs,
                 std::span<const std::complex<float>> pupil, const FarFieldWindow& window,
                 Image<std::complex<float>>& far);

}  // namespace ovws
