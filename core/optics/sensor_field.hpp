/// The sensor's field as a wavefront that nobody knows makes it: on the SLM and in the camera's
/// window.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Like SensorModel, but the wavefront is no part of the 8-bit hologram: it is added to the field
/// in steps of 1/65536 wave, each subaperture may have an amplitude of its own, and the light
/// outside the subapertures can be left out. For one thread at a time.
class SensorField {
 public:
  /// A part of the pupil small enough that a wavefront is a low polynomial on it: a subaperture, or
  /// what a square of the SLM has of the pupil outside of all of them.
  struct Piece {
    Vec2 centre_px;    ///< from the pupil's centre
    double radius_px;  ///< reaches its farthest pixel
    Vec2 grating_cpp;  ///< 0 outside the subapertures
  };
  /// The pixels of one piece in one row of the SLM: columns [begin, end).
  struct Run {
    int piece = 0;
    int y = 0;
    int begin = 0;
    int end = 0;
  };

  /// Errors as of check_straight and HologramRenderer::make. `cols` x `rows`: the camera's image.
  static Result<SensorField> make(const SensorConfig& sensor, const SlmGeometry& slm,
                                  const OpticsConfig& optics, int cols, int rows);

  const FarFieldWindow& window() const { return window_; }
  /// Middle of the SLM, from which the pupil's coordinates count.
  Vec2 pupil_centre_px() const { return pupil_centre_px_; }
  double pupil_radius_px() const { return pupil_radius_px_; }
  /// The first of pieces() are the lattice's subapertures in its order.
  int subapertures() const { return subapertures_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// Each pixel of the pupil once, by pieces. Outside the pupil no mode is shown.
  const std::vector<Run>& runs() const { return runs_; }

  /// Whether propagate() lets light outside the subapertures in; at first it does.
  void set_outside(bool lit) { outside_lit_ = lit; }
  bool outside() const { return outside_lit_; }
  /// Makes pupil() and far() anew, some 50 ms for the default bench. Requires finite modes of known
  /// index; `amplitudes` of the field, one a subaperture, or empty: all 1.
  void propagate(std::span<const Mode> modes, std::span<const double> amplitudes);

  /// On the SLM as propagated last.
  const Image<std::complex<float>>& pupil() const { return pupil_; }
  /// In the window: F of the pupil, see FarField.
  const Image<std::complex<float>>& far() const { return far_; }

 private:
  SensorField(SlmGeometry slm, FarFieldWindow window) : window_(window), far_field_(slm, window) {}
  void cut(const Lattice& lattice, const SlmGeometry& slm);

  FarFieldWindow window_;
  Vec2 pupil_centre_px_;
  double pupil_radius_px_ = 0.0;
  int subapertures_ = 0;
  std::vector<Piece> pieces_;
  std::vector<Run> runs_;
  bool outside_lit_ = true;
  Image<std::uint8_t> grey_;  ///< the hologram without any wavefront
  FarField far_field_;
  Image<std::complex<float>> pupil_;
  Image<std::complex<float>> far_;
};

}  // namespace ovws
