/// Acquisition of split spots: finds every spot in one image without history, even if a strong
/// aberration has split it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/tracking/acquisition.hpp"
#include "core/tracking/spot_assignment.hpp"
#include "core/wavefront/shape_fit.hpp"

namespace ovws {

/// Its memory is allocated for one sensor and one image size.
class ShapedAcquisition {
 public:
  /// `slopes` (of the active tracker) and `reference_px` as for a Reconstructor, without NaN.
  /// `px_per_cycle` includes the camera's rotation and parity.
  ShapedAcquisition(const Lattice& lattice, const SensorConfig& sensor, const SpotModel& spots,
                    const PxPerCycle& px_per_cycle, const std::vector<int>& modes_j,
                    const Eigen::MatrixXd& slopes, const std::vector<Vec2>& reference_px,
                    int image_width, int image_height);

  /// Runs Acquisition. If that does not find every spot with confidence, runs ShapeFit, which looks
  /// for one wavefront that explains shape and position of all spots. Its result counts only if it
  /// explains three quarters of the spots. Then a fix that is missing, or off by more than a
  /// quarter of lambda/d, is replaced by the fitted position (accurate to some hundredths of
  /// lambda/d), or lost if the fit has none. Writes and returns fixes as Acquisition::acquire does;
  /// an image of another size has none. Takes at most half a second on the default bench and
  /// allocates: not for the frame path.
  ///
  /// If `trust_tracker` is false, ShapeFit runs even if the tracker is confident of every spot: it
  /// may have found only one half of a split spot. `followed`: current positions of spots that were
  /// found earlier and tracked since, NaN: unknown. From this start a wavefront that grew slowly is
  /// explained however strong it is.
  int acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
              std::span<SpotFix> out, bool trust_tracker = true,
              const std::vector<Vec2>& followed = {});

  // Results of ShapeFit for the last image, valid until the next call:
  /// The wavefront relative to the reference, RMS-normalised waves in the order of the modes. Valid
  /// only if shapes() is not empty.
  const Eigen::VectorXd& waves() const { return waves_; }
  /// Position of each spot, and which were found. Empty if ShapeFit was not needed or failed.
  const std::vector<ShapedSpot>& shapes() const { return shapes_; }
  /// Split spots: those found by ShapeFit, but not there by the tracker.
  const std::vector<bool>& split() const { return split_; }

 private:
  std::vector<Vec2> starts_of_seen(const SpotAssignment::Rules& rules);
  bool apply(const ImageView& image, const ShapedSpot& shaped, SpotFix& fix) const;

  Acquisition plain_;
  SpotAssignment assignment_;
  double lambda_d_px_;
  std::function<ShapeModel()> make_model_;
  std::optional<ShapeModel> model_;  ///< made on first use: it is expensive for large lattices
  Eigen::VectorXd waves_;
  std::vector<ShapedSpot> shapes_;
  std::vector<bool> split_;
};

}  // namespace ovws
