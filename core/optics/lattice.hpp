/// The lattice of subapertures in the pupil, and each subaperture's grating frequency.
#pragma once

#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

struct Subaperture {
  Vec2 centre_px;      ///< V_i: SLM pixels from the pupil's centre
  Vec2 frequency_cpp;  ///< cycles per SLM pixel: ((n_x + s V_ix)/p_x, (n_y + s V_iy)/p_y), paper
                       ///< eq. 3
  int charge = 1;      ///< of the vortex that it imprints; 0: a bright spot
};

struct Lattice {
  double diameter_px = 0.0;  ///< of one subaperture, SLM pixels: D / M, or that of the lenslets
  /// Sorted by y, then x, of the centres; each circle lies entirely inside the pupil. Lenslets are
  /// in the order of SensorConfig.
  std::vector<Subaperture> subapertures;
};

/// The lattice of the sensor's lenslets, if it has any. Else places all subapertures that lie
/// entirely inside the pupil, or touch its edge from inside. The base subaperture is at the pupil's
/// centre for every M (number across), so an even M leaves half a subaperture free at the edge.
/// Errors (Errc::invalid, field "sensor.…" or "slm.width"): empty SLM; pupil larger than the SLM's
/// height or width; fewer than kMinSubapertures or more than kMaxSubapertures subapertures; a
/// grating beyond the SLM's Nyquist limit of 0.5 cycles per pixel; masks that check_masks refuses;
/// charges for another number of subapertures, or together with an alternate charge.
///
/// Charges: `sensor.charges`, one for each subaperture; or `sensor.charge`, and
/// `sensor.alternate_charge` in every second subaperture: a checkerboard in a square grid, every
/// second row in a hexagonal one, where four of a subaperture's six neighbours differ from it. The
/// base subaperture then has `sensor.charge`. All lenslets have `sensor.charge` and no mask.
Result<Lattice> make_lattice(const SensorConfig& sensor, const SlmGeometry& slm);

constexpr std::size_t kMinSubapertures = 3;
constexpr int kMaxSubapertures = 2048;
constexpr double kNyquistCpp = 0.5;  ///< limit of a grating, cycles per SLM pixel

/// Charge of each subaperture.
std::vector<int> charges_of(const Lattice& lattice);

/// Frequency of the base subaperture's grating: grooves over the SLM's size, cycles per SLM pixel.
Vec2 base_grating_cpp(const SensorConfig& sensor, const SlmGeometry& slm);

/// Model positions of the spots for a flat wavefront, camera pixels: base spot + registration
/// matrix times (f_i - f_base), the difference of the grating frequencies.
std::vector<Vec2> model_spots_px(const Lattice& lattice, const SensorConfig& sensor,
                                 const SlmGeometry& slm, const OpticsConfig& optics, int image_cols,
                                 int image_rows);

}  // namespace ovws
