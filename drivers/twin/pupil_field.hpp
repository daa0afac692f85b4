/// Light from the SLM's pupil to a window of the far field, in as few samples as the window needs.
#pragma once

#include <complex>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/chirp_z.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/far_field.hpp"
#include "drivers/twin/decimator.hpp"
#include "drivers/twin/pupil_screen.hpp"
#include "drivers/twin/slm_model.hpp"

namespace ovws::twin {

/// Far field of the pupil's light. The light without turbulence is decimated, so that another
/// moment of the turbulence costs one product per sample and a small propagation.
/// Agrees with FarField within 1e-3 of the peak up to 0.5 wave RMS of turbulence. Light that is
/// deflected by more than 12 cycles per pupil is lost. Use it in one thread at a time.
class PupilField {
 public:
  /// The pupil is centred on the SLM. `window` may be any; a narrow one is fast.
  PupilField(const SlmGeometry& slm, double diameter_px, const FarFieldWindow& window);

  /// Sets the light on the SLM without turbulence, of the SLM's size; pixels outside the pupil are
  /// ignored.
  void set_incident(const Image<std::complex<float>>& light);
  /// Light behind the SLM with these grey levels, decimated and transposed: row k is a column of
  /// the pupil. `phasors`: the factor of each grey level on the light.
  void modulate(const Image<std::uint8_t>& grey, const SlmModel::GreyPhasors& phasors,
                Image<std::complex<float>>& light);
  /// Sums the far fields `others`, which has the window's size, and that of `light`, a result of
  /// modulate. `screen`: turbulence in front of the pupil, with a margin of Decimator::kMaxReach;
  /// null: none.
  void propagate(const Image<std::complex<float>>& light, const PupilScreen* screen,
                 const Image<std::complex<float>>& others, Image<std::complex<float>>& sum);

 private:
  Columns pupil_columns(int y) const;
  void modulate_strip(const Image<std::uint8_t>& grey, const SlmModel::GreyPhasors& phasors,
                      int strip);

  Vec2 centre_px_;
  double diameter_px_;
  int first_x_px_, first_y_px_, width_, height_;  ///< the pupil's square
  Vec2 carrier_cpp_;                              ///< middle of the window
  Decimator along_x_, along_y_;
  ChirpZ to_x_, to_y_;  ///< from the values of a decimator to the window's frequencies
  /// exp(-2 pi i carrier x) for each column and row of the square: moves the window's middle to
  /// frequency 0.
  std::vector<std::complex<float>> carrier_x_, carrier_y_;
  /// Light in the square times the carriers, in strips of a few columns; 0 beside the pupil.
  std::vector<Image<std::complex<float>>> incident_;
  Image<std::complex<float>> modulated_;  ///< light of one strip behind the SLM
  Image<std::complex<float>> filtered_;   ///< the same, decimated along y
  Image<std::complex<float>> columns_;    ///< of all strips, transposed
  Image<std::complex<float>> screened_;   ///< light behind the turbulence
  Image<std::complex<float>> rows_;       ///< far field along y of each column of the light
};

}  // namespace ovws::twin
