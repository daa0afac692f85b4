/// Spots of any shape: the wavefront that makes spots of the shapes and at the places that are
/// seen.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/spot_optics.hpp"
#include "core/tracking/cell_image.hpp"

namespace ovws {

/// What is known before any image.
struct ShapeModel {
  SpotOptics optics;  ///< its cells are cell_px() camera pixels
  PixelLattice lit;   ///< the pixels that the cells are made of
  int bin = 1;        ///< so many a side
  double lambda_d_px = 12.55;
  Eigen::MatrixXd slopes;  ///< as of slope_matrix, for the modes of `optics`
  std::vector<Vec2> reference_px;

  double cell_px() const { return double(bin) * lit.step; }
};

/// One spot in one image.
struct ShapedSpot {
  bool found = false;
  Vec2 at_px;              ///< where the slopes of its wavefront put it; if found, as seen
  double amplitude = 0.0;  ///< DN, of a flat spot of that light
  double unexplained =
      1.0;  ///< share of the contrast that the shape leaves and noise does not make
};

/// Alternates between the spots, each the picture that the wavefront makes of it, moved until it
/// fits, less what the others put there; and the wavefront: modes by least squares of the cells of
/// all spots that fit, linearised in each spot's local modes, with a weak prior for small
/// aberration. So a few round spots in the middle tell how those at the rim are torn. The light of
/// spots adds up without interference: where they overlap, a fit is accepted by its amplitude.
///
/// Of one image; some ten milliseconds a round. Allocates: not for the frame path.
class ShapeFit {
 public:
  /// Both must outlive it.
  ShapeFit(const ShapeModel& model, const CellImage& image);

  /// From where spots are thought to be; NaN: unknown. Returns how many are found, all of which
  /// agree with one wavefront to half of lambda/d.
  int run(std::span<const Vec2> starts_px);

  const std::vector<ShapedSpot>& spots() const { return spots_; }
  /// RMS-normalised, in the order of the model's modes_j.
  const Eigen::VectorXd& waves() const { return waves_; }

 private:
  /// A spot's picture laid onto the image's cells.
  struct Laid {
    SpotOptics::Picture light;
    int row = 0, column = 0;  ///< of its first cell
    Vec2 aside;               ///< cells, from where the wavefront puts it
  };
  struct Match {
    double amplitude = 0.0, explained = 0.0, unexplained = 1.0, significance = 0.0;
  };
  using Local = Eigen::Matrix<double, SpotOptics::kLocal, SpotOptics::kLocal>;
  /// What one spot's cells tell of its local modes, from those of the wavefront: normal equations.
  struct Information {
    Local matrix;
    Eigen::Matrix<double, SpotOptics::kLocal, 1> pull;
  };
  struct Rules {
    double reach, most_unexplained, least_amplitude, most_aside;
  };

  Eigen::VectorXd prior_weights() const;
  void modes_from_places(std::span<const Vec2> starts_px);
  double modes_from_shapes();  ///< how far they went, waves RMS
  Vec2 middle_cells(int spot) const;
  void lay(int spot);
  void add(int spot, double sign);
  Match match(int spot, int right, int down) const;
  void seek(int spot, const Rules& rules);
  bool accepted(int spot, const Match& match, const Rules& rules) const;
  double usual_amplitude(int spot) const;
  void look(const Rules& rules);
  Information information(int spot) const;
  Eigen::Vector2d tilts_aside(int spot) const;
  void place();

  const ShapeModel& model_;
  const CellImage& image_;
  Eigen::VectorXd waves_;
  std::vector<ShapedSpot> spots_;
  std::vector<Laid> laid_;
  Eigen::MatrixXf others_;  ///< the light of all found spots
};

}  // namespace ovws
