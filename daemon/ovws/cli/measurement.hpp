/// Offline measurement of image files, with the same code that measures the daemon's frames.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "core/pipeline/verdict.hpp"
#include "core/spots/point_model.hpp"
#include "core/tracking/acquisition.hpp"
#include "daemon/ovwsd/fitter/refined_modes.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws::cli {

/// The measurement of one image.
struct Measured {
  std::vector<SpotFix> spots;  ///< one per subaperture
  int tracked = 0;
  double saturated = 0.0;           ///< fraction of the spots that are saturated
  std::vector<float> coefficients;  ///< waves, order of the plan's modes_j; NaN if not measured
  std::vector<float> sigma_waves;   ///< standard errors; NaN unless `fitted`
  Reconstruction reconstruction;
  std::vector<BranchPoint> branch_points;  ///< of the light; then the image is not valid
  Verdict verdict = Verdict::spots_lost;
  bool fitted = false;  ///< by all pixels of the spots (tracker `fit`), else by positions
  std::optional<RefinedModes> refined{};  ///< only with a known camera
  std::string refused;                    ///< why a refined image is not valid; empty: it is valid
  OperatorReport mode_operator;           ///< the operator that gave the coefficients
};

/// Measures images of one size. One thread at a time.
class Measurement {
 public:
  /// Prepares a measurement. `reference`: an image taken without aberration; none: the model gives
  /// the reference positions. With `camera`, `fit` uses this camera's noise and images are valid
  /// only if they can be refined; without it, the noise comes from the image. Errors: an unusable
  /// configuration; an operator that cannot be made; a reference image of another size, with
  /// missing spots (named in the error), or that `fit` cannot explain.
  static Result<Measurement> make(const Config& config, const ImageView& like,
                                  const std::optional<ImageView>& reference,
                                  const std::optional<RefineCamera>& camera = std::nullopt);

  /// Measures an image without history: Acquisition searches every spot, then `fit` finds the
  /// wavefront from all pixels (PointModel). Finds no spots in an image that does not have the size
  /// that the plan was made for.
  Measured measure(const ImageView& image);
  const MeasurementPlan& plan() const { return *plan_; }

 private:
  explicit Measurement(std::unique_ptr<MeasurementPlan> plan);
  Result<void> use_templates(const Config& config, const ImageView& like,
                             const std::optional<ImageView>& reference,
                             std::span<const float> start);
  std::vector<std::vector<double>> starts(const Measured& measured) const;
  void fit(const ImageView& image, Measured& measured);
  void refine(const ImageView& image, Measured& measured);
  Verdict by_positions(Measured& measured);
  std::unique_ptr<MeasurementPlan> plan_;
  std::optional<PointModel> model_;  ///< used by the tracker `fit` only
  std::optional<RefineCamera> camera_;
  OperatorReport mode_operator_;
  bool counts_from_image_ = false;  ///< modes are relative to the reference image; false: absolute
  Acquisition acquisition_;
  TrackScratch track_scratch_;
  Reconstructor::Scratch solve_scratch_;
};

/// The operator that measures images with these settings, and why it is not the configured one.
OperatorReport operator_report(const TrackingSettings& tracking);

/// Refuses a fixed array that is turned in the image by more than 0.5 degrees: its slopes would be
/// along the camera's axes, and its lenslets along its own. `plan`: one whose predicted positions
/// are those of the model. Errc::refused, field `field`.
Result<void> check_rotation(const Config& config, const MeasurementPlan& plan,
                            std::span<const SpotFix> spots, std::string_view field);

}  // namespace ovws::cli
