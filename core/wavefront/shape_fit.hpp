/// Model-based fit of spots of any shape: the wavefront whose computed spots match an image in
/// shape and position.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/spot_optics.hpp"
#include "core/tracking/binned_image.hpp"

namespace ovws {

/// The sensor model, which does not depend on the image.
struct ShapeModel {
  SpotOptics optics;  ///< its images have bins of bin_px() camera pixels
  ColourPlane lit;    ///< the colour plane that is binned
  int bin = 1;        ///< pixels of the plane per side of a bin
  double lambda_d_px = 12.55;
  Eigen::MatrixXd slopes;  ///< as of slope_matrix, for the modes of `optics`
  std::vector<Vec2> reference_px;

  double bin_px() const { return double(bin) * lit.step; }
};

/// One spot in one image.
struct ShapedSpot {
  bool found = false;
  Vec2 at_px;                ///< if found, as measured; else where the wavefront's slopes put it
  double amplitude = 0.0;    ///< DN, peak of the same spot without aberration
  double unexplained = 1.0;  ///< share of the contrast that neither the shape nor noise explains
};

/// Alternates between the spots and the wavefront. Spots: the computed image of each spot is moved
/// until it fits the image minus all other spots. Wavefront: least squares over the bins of all
/// accepted spots, linearised in each spot's local modes, with a weak prior for small aberrations.
/// Thus a few round spots in the middle predict how those at the rim are split. Intensities of
/// overlapping spots add up without interference; such fits are accepted by their amplitude.
///
/// For one image; some ten milliseconds per round. Allocates: not for the frame path.
class ShapeFit {
 public:
  /// Both must outlive it.
  ShapeFit(const ShapeModel& model, const BinnedImage& image);

  /// Fits from estimated spot positions; NaN: unknown. Returns how many spots are found, all of
  /// which agree with one wavefront to half of lambda/d.
  int run(std::span<const Vec2> starts_px);

  const std::vector<ShapedSpot>& spots() const { return spots_; }
  /// RMS-normalised, in the order of the model's modes_j.
  const Eigen::VectorXd& waves() const { return waves_; }

 private:
  /// A spot's computed image, aligned with the bins of the camera's image.
  struct Rendered {
    SpotOptics::Picture intensity;
    int row = 0, column = 0;  ///< of its first bin
    Vec2 offset;              ///< bins, from where the wavefront puts it
  };
  struct Match {
    double amplitude = 0.0, explained = 0.0, unexplained = 1.0, significance = 0.0;
  };
  using Local = Eigen::Matrix<double, SpotOptics::kLocal, SpotOptics::kLocal>;
  /// Normal equations of one spot's local modes, relative to those of the wavefront.
  struct Information {
    Local matrix;
    Eigen::Matrix<double, SpotOptics::kLocal, 1> gradient;
  };
  struct Rules {
    double reach, max_unexplained, min_amplitude, max_offset;
  };

  Eigen::VectorXd prior_weights() const;
  void fit_modes_to_positions(std::span<const Vec2> starts_px);
  double fit_modes_to_shapes();  ///< returns the length of the step, waves RMS
  Vec2 predicted_bin(int spot) const;
  void render(int spot);
  void add(int spot, double sign);
  Match match(int spot, int right, int down) const;
  void search(int spot, const Rules& rules);
  bool accepted(int spot, const Match& match, const Rules& rules) const;
  double usual_amplitude(int spot) const;
  void update_spots(const Rules& rules);
  Information information(int spot) const;
  Eigen::Vector2d offset_tilts(int spot) const;
  void refine_positions();

  const ShapeModel& model_;
  const BinnedImage& image_;
  Eigen::VectorXd waves_;
  std::vector<ShapedSpot> spots_;
  std::vector<Rendered> rendered_;
  Eigen::MatrixXf others_;  ///< computed intensity of all found spots
};

}  // namespace ovws
