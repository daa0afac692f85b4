/// Finds every spot in one image without history, those too that an aberration has torn apart.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/tracking/acquisition.hpp"
#include "core/tracking/consensus.hpp"
#include "core/wavefront/shape_fit.hpp"

namespace ovws {

/// Memory for one sensor and one image size.
class ShapedAcquisition {
 public:
  /// `slopes` (of the tracker in use) and `reference_px` as a Reconstructor has them, NaN nowhere;
  /// `px_per_cycle`: the camera may be turned and mirrored.
  ShapedAcquisition(const Lattice& lattice, const SensorConfig& sensor, const SpotModel& spots,
                    const PxPerCycle& px_per_cycle, const std::vector<int>& modes_j,
                    const Eigen::MatrixXd& slopes, const std::vector<Vec2>& reference_px,
                    int image_width, int image_height);

  /// What Acquisition finds; and if that is not every spot for sure, those that have the shape and
  /// the place of the one wavefront which explains the image (ShapeFit). Believed only if it
  /// explains three quarters of all spots: then a fix of the tracker's that is off by more than a
  /// quarter of lambda/d, or missing, is replaced by the place that the fit gives, right to some
  /// hundredths of lambda/d, or lost. Half a second at most on the default bench, and it allocates:
  /// not for the frame path. As Acquisition::acquire otherwise; an image of another size has
  /// nothing. Without `believe_sure` the image is explained even if the tracker is sure of every
  /// spot: it may have found torn ones in their wrong half. `followed`: where the spots of earlier
  /// images are by now, NaN unknown; what a wavefront that grew slowly is explained from, however
  /// strong it is.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out, bool believe_sure = true,
              const std::vector<Vec2>& followed = {});

  // If the last image needed ShapeFit and was explained by it, until the next call:
  /// the wavefront, RMS-normalised waves in the order of the modes, counted from the reference;
  const Eigen::VectorXd& waves() const { return waves_; }
  /// where it puts each spot, and which of them were found; empty if it was not so;
  const std::vector<ShapedSpot>& shapes() const { return shapes_; }
  /// and which of those the tracker did not find there: torn.
  const std::vector<bool>& torn() const { return torn_; }

 private:
  std::vector<Vec2> starts_of_seen(const Consensus::Rules& rules);
  bool take(const ImageView& image, const ShapedSpot& shaped, SpotFix& fix) const;

  Acquisition plain_;
  Consensus consensus_;
  double lambda_d_px_;
  std::function<ShapeModel()> make_model_;
  std::optional<ShapeModel> model_;  ///< made when first needed: it is dear for large lattices
  Eigen::VectorXd waves_;
  std::vector<ShapedSpot> shapes_;
  std::vector<bool> torn_;
};

}  // namespace ovws
