/// The light of every pixel round the spots as a function of the modes, and its normal equations.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/optics/piece_moments.hpp"
#include "core/optics/sensor_field.hpp"

namespace ovws {

/// What is fitted: light of a pixel = scale |F|^2 + background, electrons.
struct RefineState {
  Eigen::VectorXd waves;           ///< of each mode, RMS-normalised
  double scale_e = 0.0;            ///< electrons per |F|^2
  double background_e = 0.0;       ///< a pixel
  std::vector<double> amplitudes;  ///< of each subaperture's field; empty: all 1, not fitted
};

/// Sums over the pixels, the weights being 1 / (light + read noise^2) at the state.
struct RefineSums {
  Eigen::MatrixXd fisher;    ///< J^T W J; parameters: modes, ln scale, background, ln amplitudes
  Eigen::VectorXd gradient;  ///< J^T W (seen - model)
  double chi2 = 0.0;
  double deviance = 0.0;    ///< -2 ln likelihood, but for a constant a pixel
  Eigen::Index pixels = 0;  ///< that counted
};

/// For one thread at a time. Working memory is made once for a geometry and kept.
///
/// The light is that of the whole SLM (SensorField). Derivatives are those of each piece within a
/// box where its light falls, every mode a polynomial of degree 3 there (PieceMoments): that can
/// bend the way to the minimum, hardly its place.
class RefineSystem {
 public:
  /// `box_half_px`: half the side of the square round each predicted spot whose pixels count.
  RefineSystem(SensorField field, std::vector<int> modes_j, int box_half_px);

  const std::vector<int>& modes_j() const { return modes_j_; }
  const SensorField& field() const { return field_; }

  /// Takes light outside the subapertures as part of the model; at first it is.
  void model_outside();
  /// Takes it as noise: coherent light of unknown phase, as strong as it is now, 5 x 5 pixels
  /// averaged.
  void doubt_outside(const RefineState& state);
  /// Seen light, electrons above the black level; a NaN does not count. Of the window's size.
  void see(const Image<float>& electrons, double read_noise_e);

  /// Light of the state, of which all below speaks. Some 50 ms.
  void propagate(const RefineState& state);
  /// Chooses the pixels, and sets scale and background to what suits them best, by least squares.
  void match_light(RefineState& state);
  /// Chooses pixels and weights anew and sums up. Some 50 ms.
  RefineSums linearise(const RefineState& state);
  /// |F|^2 of the brightest pixel that counts.
  double brightest() const;
  /// Sum of weights times (seen - model)^2 with the pixels and weights of the last `linearise`.
  double misfit(const RefineState& state) const;

 private:
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// What is expected of a pixel, and with what variance.
  struct Expected {
    double light = 0.0;
    double variance = 0.0;
  };
  Expected expected(const RefineState& state, std::size_t pixel) const;

  void choose_pixels(const RefineState& state);
  void fill_columns(const RefineState& state);
  void add_piece(const RefineState& state, int piece, const PixelBox& box);
  PixelBox box_of(int piece, std::span<const Mode> modes) const;
  bool counts(const PixelBox& box) const;
  std::vector<Mode> modes_of(const RefineState& state) const;

  SensorField field_;
  PieceMoments moments_;
  std::vector<int> modes_j_;
  int box_half_px_;
  Image<float> seen_;
  double noise_variance_ = 1.0;
  std::vector<float> stray_;  ///< |F|^2 of the outside where it counts as noise, else empty
  Image<int> number_;         ///< of a pixel among those that count, else -1
  std::vector<std::size_t> pixels_;
  std::vector<float> weights_;  ///< square roots
  Rows columns_;                ///< d light / d parameter
  Eigen::MatrixXf piece_;
  Rows piece_modes_;
};

}  // namespace ovws
