/// The hologram: phase -> + aberration - correction -> + flatness -> wrap -> LUT -> grey levels.
///
/// Exact rounding: pattern plus flatness, and the sum of the modes, are each rounded to the nearest
/// 1/65536 wave (ties to even) and added modulo one wave. The top 8 of the 16 bits index the LUT.
/// The sum of the modes is as accurate as a power sum in double precision: for modes of moderate
/// strength and order it errs by less than 1/1024 of such a step; closer than that to a tie it may
/// round either way. The grey levels do not depend on the CPU's instruction set.
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

/// Phase look-up table: the grey level for each of 256 equal steps of phase over [0, 2 pi), rounded
/// down. The linear LUT shows step k as grey level k.
using PhaseLut = std::array<std::uint8_t, 256>;
PhaseLut linear_lut();

enum class HologramKind {
  sensor,    ///< subapertures with their gratings and vortices
  grating,   ///< base grating over the pupil plus the modes: the corrected beam
  flat,      ///< flatness map only
  identify,  ///< test image by which a person recognises the SLM's screen
  test,      ///< image drawn by a job: a probe, stripes
};

/// A single subaperture shown alone: it measures the registration (slope to camera position) and
/// the local slope of the incoming light.
struct Probe {
  Vec2 frequency_cpp;  ///< grating frequency, cycles per SLM pixel
  int charge = 0;
  Vec2 centre_px = {};           ///< SLM pixels from the pupil's centre
  double diameter_px = 0.0;      ///< 0: as the lattice's subapertures
  std::vector<Mode> modes = {};  ///< wavefront to add, over the sensor's pupil
};

/// Inputs of the hologram. All phases in waves.
struct HologramConfig {
  SlmGeometry slm;
  SensorConfig sensor;
  PhaseLut lut = linear_lut();
  /// Flatness map: phase to add at each SLM pixel to make the SLM flat, waves. Size width x height;
  /// null: none.
  std::shared_ptr<const Image<float>> flatness_waves;
};

/// The modes to render a hologram of `kind` with, waves: the aberration minus the correction.
/// `grating`, the corrected beam, leaves out the aberration.
std::vector<Mode> shown_modes(HologramKind kind, std::vector<Mode> aberration,
                              std::span<const Mode> correction);

/// Renders holograms. Immutable after construction, which takes milliseconds; all methods are
/// thread-safe. Outside the subapertures the sensor's phase is 0 (plus flatness).
class HologramRenderer {
 public:
  static Result<HologramRenderer> make(const HologramConfig& config);

  const Lattice& lattice() const { return lattice_; }

  /// Renders `kind` and resizes `grey` to the SLM's size. `modes` is the wavefront to add
  /// (aberration - correction); `check_sampling` must accept it. It is added inside the pupil only:
  /// outside, where high orders diverge, the light stays in the zeroth order. `flat`, `identify`
  /// and `test` ignore it; `test` shows flat. Takes a fraction of a millisecond per megapixel for
  /// any number of modes.
  void render(HologramKind kind, std::span<const Mode> modes, Image<std::uint8_t>& grey) const;
  /// Renders a single subaperture. Requires a frequency of at most 0.5 in x and y and valid modes.
  void render_probe(const Probe& probe, Image<std::uint8_t>& grey) const;

  /// Nyquist check. Errors (Errc::invalid, field "modes") if the total slope (grating and `modes`)
  /// exceeds half a cycle per SLM pixel in x or y anywhere inside a subaperture, or if a mode's
  /// index or coefficient is out of range.
  Result<void> check_sampling(std::span<const Mode> modes) const;

 private:
  HologramRenderer() = default;
  /// Pattern plus flatness of row y, `width` pixels, 2 pi = 65536. `waves`: working memory of the
  /// same length.
  void pattern_row(HologramKind kind, int y, std::span<double> waves, std::uint16_t* phase) const;
  Image<std::uint8_t>& sized(Image<std::uint8_t>& grey) const;

  HologramConfig config_;
  Lattice lattice_;
  std::vector<std::uint16_t>
      base_phase_;  ///< sensor phase and flatness, 2 pi = 65536: integer overflow wraps it
  Image<std::uint8_t> base_grey_;  ///< the sensor without modes, for pixels outside the pupil
};

}  // namespace ovws
