/// The hologram: phase -> + aberration - correction -> + flatness -> wrap -> LUT -> grey levels.
///
/// Exact rounding: pattern plus flatness, and the sum of the modes, are each rounded to the nearest
/// 1/65536 wave (ties to even) and added modulo one wave. The top 8 of the 16 bits index the LUT.
/// On a DMD the 16 bits decide, pixel by pixel, whether a mirror is on (255) or off (0); see
/// dmd.hpp. The sum of the modes is a power sum in double precision. For modes of moderate strength
/// and order its error is below 1/1024 of a 1/65536-wave step, so only sums that close to a tie may
/// round either way. The grey levels do not depend on the CPU's instruction set.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/dmd.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Phase look-up table (LUT): grey level for each of 256 equal phase steps over [0, 2 pi). Phases
/// are rounded down to a step. The linear LUT shows step k as grey level k.
using PhaseLut = std::array<std::uint8_t, 256>;
PhaseLut linear_lut();

enum class HologramKind {
  sensor,    ///< subapertures with their gratings and vortices
  grating,   ///< base grating over the pupil minus the correction: corrected beam
  flat,      ///< flatness map only
  identify,  ///< test image by which a person recognises the SLM's screen
  test,      ///< image drawn by a job: a probe, stripes
};

/// Probe: a single subaperture shown alone. Its spot measures the registration (slope to camera
/// position) and the local slope of the incoming wavefront.
struct Probe {
  Vec2 frequency_cpp;  ///< grating frequency, cycles per SLM pixel
  int charge = 0;
  Vec2 centre_px = {};           ///< SLM pixels from the pupil's centre
  double diameter_px = 0.0;      ///< SLM pixels; 0: diameter of the lattice's subapertures
  std::vector<Mode> modes = {};  ///< wavefront to add, over the sensor's pupil
};

/// A picture from outside, shown in place of the sensor.
struct Picture {
  Image<float> waves;            ///< phase, waves, finite; of the SLM's size
  std::vector<Mode> modes = {};  ///< wavefront to add inside the pupil
  bool flatness = true;          ///< whether to add the flatness map
  /// false: the top 8 bits of the phase are the grey levels; on a DMD the top bit is the mirror's
  bool lut = true;
  bool inside_pupil = false;  ///< whether the phase is 0 outside the sensor's pupil
};

/// Inputs of the hologram renderer. All phases in waves.
struct HologramConfig {
  SlmGeometry slm;
  SensorConfig sensor;
  PhaseLut lut = linear_lut();
  /// Flatness map: phase in waves to add at each SLM pixel to make the SLM optically flat. Must
  /// have the SLM's size; null: no flatness correction.
  std::shared_ptr<const Image<float>> flatness_waves;
  std::optional<DmdConfig> dmd = std::nullopt;  ///< of a DMD, which has no LUT; none: an SLM
};

/// Modes to pass to render() for a hologram of `kind`, waves: aberration minus correction. For
/// HologramKind::grating (the corrected beam) only minus the correction.
std::vector<Mode> shown_modes(HologramKind kind, std::vector<Mode> aberration,
                              std::span<const Mode> correction);

/// Renders holograms. Construction takes milliseconds. Immutable afterwards, so all methods are
/// thread-safe. Draws nothing for a sensor with lenslets. Outside the subapertures the sensor
/// hologram's phase is 0 plus flatness and modes; on a DMD the mirrors are off there.
class HologramRenderer {
 public:
  /// Errors: as of make_lattice and check_dmd, or Errc::invalid if the flatness map has a wrong
  /// size or NaN.
  static Result<HologramRenderer> make(const HologramConfig& config);

  const Lattice& lattice() const { return lattice_; }

  /// Renders `kind` into `grey`, resized to the SLM's size. `modes`: wavefront to add (aberration -
  /// correction); check_sampling must accept these modes. They are added only inside the pupil,
  /// because high orders diverge outside. `flat`, `identify` and `test` ignore `modes`; `test`
  /// renders the same image as `flat`. Takes a fraction of a millisecond per megapixel for any
  /// number of modes.
  void render(HologramKind kind, std::span<const Mode> modes, Image<std::uint8_t>& grey) const;
  /// Renders a single subaperture. Requires valid modes and a grating frequency of at most 0.5
  /// cycles per SLM pixel in x and y.
  void render_probe(const Probe& probe, Image<std::uint8_t>& grey) const;
  /// Renders a picture, whose size must be the SLM's, with valid modes.
  void render_picture(const Picture& picture, Image<std::uint8_t>& grey) const;

  /// Nyquist check. Errors (Errc::invalid, field "modes") if the total slope (grating and `modes`)
  /// exceeds half a cycle per SLM pixel in x or y anywhere inside a subaperture, or if a mode's
  /// index or coefficient is out of range.
  Result<void> check_sampling(std::span<const Mode> modes) const;

 private:
  HologramRenderer() = default;
  /// Pattern plus flatness of row y as 16-bit phase (65536 = 2 pi). `waves`: working memory. Both
  /// `waves` and `phase` have the SLM's width.
  void pattern_row(HologramKind kind, int y, std::span<double> waves, std::uint16_t* phase) const;
  /// Limits of a DMD's mirrors in row y of any kind but the sensor's hologram.
  void limits_row(HologramKind kind, int y, std::vector<std::uint16_t>& limits) const;
  /// Grey levels of `count` pixels. `limits`: of a DMD's mirrors; not used for an SLM.
  void levels(const std::uint16_t* base, const std::uint16_t* added, const std::uint16_t* limits,
              int count, std::uint8_t* grey) const;
  Image<std::uint8_t>& sized(Image<std::uint8_t>& grey) const;

  HologramConfig config_;
  Lattice lattice_;
  std::vector<std::uint16_t>
      base_phase_;  ///< sensor phase and flatness, 2 pi = 65536: integer overflow wraps it
  std::vector<std::uint16_t> limits_;  ///< of a DMD's mirrors, of the sensor's hologram
  Image<std::uint8_t> base_grey_;      ///< grey levels without modes, for pixels outside the pupil
};

}  // namespace ovws
