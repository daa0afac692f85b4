/// Light from the SLM's pupil to a window of the far field, in as few samples as the window needs.
#pragma once

#include <complex>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/far_field.hpp"
#include "drivers/twin/decimator.hpp"
#include "drivers/twin/pupil_screen.hpp"

namespace ovws::twin {

/// Far field of the pupil's light. It keeps the light without turbulence, decimated, so that
/// another moment of the turbulence costs one product per sample and a small propagation.
/// Agrees with FarField within 1e-3 of the peak up to 0.5 wave RMS of turbulence. Light that is
/// deflected by more than 12 cycles per pupil is lost. Use it in one thread at a time.
class PupilField {
 public:
  /// The pupil is centred on the SLM. `window` may be any; a narrow one is fast.
  PupilField(const SlmGeometry& slm, double diameter_px, const FarFieldWindow& window);

  /// Sets the light without turbulence. `field`: as behind the SLM, of its size; pixels outside the
  /// pupil are ignored.
  void set_light(const Image<std::complex<float>>& field);
  /// Adds the pupil's far field to `far`, which has the window's size. `screen`: turbulence in
  /// front of the pupil, with a margin of Decimator::kMaxReach; null: none.
  void add_to(Image<std::complex<float>>& far, const PupilScreen* screen);

 private:
  void demodulate(const Image<std::complex<float>>& field, int y, std::complex<float>* line) const;

  Vec2 centre_px_;
  double diameter_px_;
  int first_x_px_, first_y_px_, width_, height_;  ///< the pupil's square
  Vec2 carrier_cpp_;                              ///< middle of the window
  Decimator along_x_, along_y_;
  FarField far_field_;
  /// exp(-2 pi i carrier x) for each column and row of the square: moves the window's middle to
  /// frequency 0.
  std::vector<std::complex<float>> carrier_x_, carrier_y_;
  std::vector<std::complex<float>> gain_x_, gain_y_;  ///< Decimator::gain at the window's points
  Image<std::complex<float>> half_;                   ///< light decimated along x
  Image<std::complex<float>> light_;                  ///< light decimated along x and y
  Image<std::complex<float>> screened_;               ///< light_ behind the turbulence
  Image<std::complex<float>> far_;
};

}  // namespace ovws::twin
