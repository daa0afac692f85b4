/// Diffraction model of the sensor for an incoming wavefront: complex field on the SLM and in the
/// camera's window.
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

/// Differs from SensorModel in three ways: the wavefront is added to the field in steps of 1/65536
/// wave instead of to the 8-bit hologram, each subaperture may have its own amplitude, and stray
/// light from outside the subapertures can be excluded. For one thread at a time.
class SensorField {
 public:
  /// A part of the pupil on which a wavefront is a low-order polynomial: a subaperture, or the part
  /// of a square tile that lies in the pupil but in no subaperture.
  struct Piece {
    Vec2 centre_px;    ///< from the pupil's centre
    double radius_px;  ///< to its farthest pixel
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
  /// Centre of the SLM, the origin of pupil coordinates.
  Vec2 pupil_centre_px() const { return pupil_centre_px_; }
  double pupil_radius_px() const { return pupil_radius_px_; }
  /// The first of pieces() are the lattice's subapertures in its order.
  int subapertures() const { return subapertures_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// All pixels of the pupil, each once, sorted by piece. Modes are not applied outside the pupil.
  const std::vector<Run>& runs() const { return runs_; }

  /// Whether propagate() includes the light outside the subapertures; by default it does.
  void set_outside(bool lit) { outside_lit_ = lit; }
  bool outside() const { return outside_lit_; }
  /// What the light does besides the modes; empty: nothing.
  struct Light {
    std::span<const double> amplitudes{};  ///< of the field over each subaperture
    std::span<const Mode> ln_amplitude{};  ///< logarithm of the field's amplitude over the pupil
    std::span<const Vec2> slopes_cpp{};    ///< of the phase over each subaperture
  };
  /// Computes pupil() and far(), some 50 ms for the default bench. Requires finite modes of valid
  /// index.
  void propagate(std::span<const Mode> modes, const Light& light);

  /// The field on the SLM of the last propagate().
  const Image<std::complex<float>>& pupil() const { return pupil_; }
  /// The far field in the window, see FarField.
  const Image<std::complex<float>>& far() const { return far_; }

 private:
  SensorField(SlmGeometry slm, FarFieldWindow window) : window_(window), far_field_(slm, window) {}
  void split_into_pieces(const Lattice& lattice, const SlmGeometry& slm);

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
