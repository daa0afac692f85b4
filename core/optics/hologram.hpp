/// The hologram: phase -> + aberration - correction -> + flatness -> wrap -> LUT -> grey levels.
///
/// Rounding, exactly: pattern and flatness together, and the sum of the modes, are each rounded to
/// the nearest 1/65536 wave (pattern and flatness: a tie to the even one), added modulo one wave,
/// and the top 8 bits of the 16 index the LUT. The sum of the modes is known to 1/1024 of such a
/// step: nearer than that to a tie, either neighbour may be taken. Where double precision cannot
/// resolve it so well (strong modes of high orders), it is as good as a double sum of powers. The
/// greys do not depend on the CPU's instruction set.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Grey level to show for each of 256 equal steps of phase over [0, 2 pi): grey = lut[round-down
/// step]. The linear one shows step k as grey k.
using PhaseLut = std::array<std::uint8_t, 256>;
PhaseLut linear_lut();

enum class HologramKind {
  sensor,    ///< subapertures with their gratings and vortices
  grating,   ///< base grating over the pupil, and the correction: the corrected beam
  flat,      ///< flatness map only
  identify,  ///< a picture that a person recognises: which screen is the SLM
  test,      ///< what a job paints: a probe, stripes
};

/// One lone subaperture: for finding out where the camera sees which slope, and which slope the
/// light has where.
struct Probe {
  Vec2 frequency_cpp;  ///< of its grating, cycles per SLM pixel
  int charge = 0;
  Vec2 centre_px = {};           ///< SLM pixels from the pupil's centre
  double diameter_px = 0.0;      ///< 0: that of the lattice's subapertures
  std::vector<Mode> modes = {};  ///< wavefront to add, over the sensor's pupil
};

/// What the hologram is made of. All phases in waves.
struct HologramConfig {
  SlmGeometry slm;
  SensorConfig sensor;
  PhaseLut lut = linear_lut();
  /// Phase to add at each SLM pixel so that the SLM becomes flat, waves; empty: none. Size width x
  /// height.
  std::shared_ptr<const Image<float>> flatness_waves;
};

/// Immutable after construction (which takes milliseconds); `render` is thread-safe and meant for
/// the prepare thread. Outside the subapertures the sensor's phase is 0 (plus flatness).
class HologramRenderer {
 public:
  static Result<HologramRenderer> make(const HologramConfig& config);

  const Lattice& lattice() const { return lattice_; }

  /// Grey levels of `width x height`. `modes` is the wavefront to add (aberration - correction),
  /// which `check_sampling` must accept: to the pixels in the pupil's circle, so that what lies
  /// outside, where modes of high order grow without limit, stays in the zero order. `flat` and
  /// `identify` leave it out. However many modes: a fraction of a millisecond a megapixel, or
  /// several where only double precision will do.
  /// `test` is not for it: it shows flat.
  void render(HologramKind kind, std::span<const Mode> modes, Image<std::uint8_t>& grey) const;
  /// Requires a frequency of at most 0.5 in x and y, and valid mode indices.
  void render_probe(const Probe& probe, Image<std::uint8_t>& grey) const;

  /// Errors (Errc::invalid, field "modes") if somewhere inside a subaperture the total phase
  /// (gratings and `modes`) would exceed half a cycle per SLM pixel in x or y: the SLM cannot
  /// sample it.
  Result<void> check_sampling(std::span<const Mode> modes) const;

 private:
  HologramRenderer() = default;
  /// Pattern and flatness of row y, `width` pixels, 2 pi = 65536. `waves`: as many of working
  /// memory.
  void pattern_row(HologramKind kind, int y, std::span<double> waves, std::uint16_t* phase) const;
  Image<std::uint8_t>& sized(Image<std::uint8_t>& grey) const;

  HologramConfig config_;
  Lattice lattice_;
  std::vector<std::uint16_t>
      base_phase_;                 ///< sensor phase and flatness, 2 pi = 65536: wraps by itself
  Image<std::uint8_t> base_grey_;  ///< the sensor without modes: what shows outside the pupil
};

}  // namespace ovws
