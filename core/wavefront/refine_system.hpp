/// Forward model of the refinement: the intensity of every pixel around the spots as a function of
/// the modes, and its normal equations.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/optics/piece_moments.hpp"
#include "core/optics/sensor_field.hpp"

namespace ovws {

/// Fitted parameters. Intensity of a pixel = scale |F|^2 + background, electrons.
struct RefineState {
  Eigen::VectorXd waves;           ///< of each mode, RMS-normalised
  double scale_e = 0.0;            ///< electrons per |F|^2
  double background_e = 0.0;       ///< per pixel
  std::vector<double> amplitudes;  ///< of each subaperture's field; empty: all 1, not fitted
};

/// Normal equations: sums over the pixels with the weights 1 / variance at the state.
struct RefineSums {
  Eigen::MatrixXd fisher;    ///< J^T W J; parameters: modes, ln scale, background, ln amplitudes
  Eigen::VectorXd gradient;  ///< J^T W (measured - model)
  double chi2 = 0.0;
  double deviance = 0.0;    ///< -2 ln likelihood, up to a constant per pixel
  Eigen::Index pixels = 0;  ///< number of pixels used
};

/// Use it from one thread at a time. Working memory is allocated once per geometry.
///
/// The intensity is that of the whole SLM (SensorField). The derivatives are approximate: a
/// piece of the pupil (PupilPiece) contributes only to pixels in a box around its spot, and
/// every mode is a polynomial of degree 3 over the piece (PieceMoments). This may slow convergence
/// but hardly moves the minimum.
class RefineSystem {
 public:
  /// `box_half_px`: half-width of the square of pixels used around each predicted spot.
  RefineSystem(SensorField field, std::vector<int> modes_j, int box_half_px);

  const std::vector<int>& modes_j() const { return modes_j_; }
  const SensorField& field() const { return field_; }

  /// Models the stray light from outside the subapertures; this is the initial state.
  void model_outside();
  /// Treats the stray light as noise: coherent light of unknown phase and of its intensity at
  /// `state`, averaged over 5 x 5 pixels. Propagates `state` without it.
  void treat_outside_as_noise(const RefineState& state);
  /// Sets the measured image: electrons above the black level, of the window's size; NaN is
  /// ignored.
  void set_image(const Image<float>& electrons, double read_noise_e);

  /// Computes the far field of `state`, which all methods below use. About 7 ms.
  void propagate(const RefineState& state);
  /// Selects the pixels, and fits scale and background to them by unweighted least squares.
  void fit_scale_and_background(RefineState& state);
  /// Selects pixels and weights again and sums the normal equations. About 50 ms.
  RefineSums linearise(const RefineState& state);
  /// |F|^2 of the brightest pixel in use.
  double brightest() const;
  /// Sum of weights times (measured - model)^2 with the pixels and weights of the last `linearise`.
  double misfit(const RefineState& state) const;

 private:
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Expected intensity and variance of a pixel.
  struct Expected {
    double light = 0.0;
    double variance = 0.0;
  };
  Expected expected(const RefineState& state, std::size_t pixel) const;

  void choose_pixels(const RefineState& state);
  void fill_columns(const RefineState& state);
  void add_piece(const RefineState& state, int piece, const PixelBox& box);
  PixelBox box_of(int piece, std::span<const Mode> modes) const;
  bool has_used_pixels(const PixelBox& box) const;
  std::vector<Mode> modes_of(const RefineState& state) const;

  SensorField field_;
  PieceMoments moments_;
  std::vector<int> modes_j_;
  int box_half_px_;
  Image<float> image_;
  double noise_variance_ = 1.0;
  std::vector<float> stray_;  ///< |F|^2 of the stray light if it is treated as noise, else empty
  Image<int> index_;          ///< index of a pixel in pixels_, or -1
  std::vector<std::size_t> pixels_;
  std::vector<float> weights_;  ///< square roots of the weights
  Rows columns_;                ///< Jacobian: d intensity / d parameter
  Eigen::MatrixXf piece_;
  Rows piece_modes_;
};

}  // namespace ovws
