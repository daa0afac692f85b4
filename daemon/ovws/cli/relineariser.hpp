/// The `relinearised` operator for image files: Gauss-Newton steps with a fixed slope matrix about
/// the diffraction model's spot positions.
#pragma once

#include <memory>
#include <vector>

#include "config/config.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "core/wavefront/relinearise.hpp"

namespace ovws::cli {

/// For images of one size. Takes about 0.1 s per image; one thread at a time.
class Relineariser {
 public:
  /// `measured`: the plan's reference comes from an image; displacements from it are taken as
  /// displacements from the model's flat wavefront. Else positions are compared directly. Errors:
  /// as SensorModel::make and make_tracker; Errc::refused for a rotated or mirrored camera.
  static Result<Relineariser> make(const Config& config, const MeasurementPlan& plan,
                                   bool measured);

  /// Ignores split spots (`split`): the tracker does not find them at their true place. Errors: as
  /// relinearise; Errc::refused if the steps do not converge.
  Result<Relinearised> measure(const std::vector<SpotFix>& spots, const std::vector<int>& split,
                               const std::vector<float>& linear);

 private:
  Relineariser(SensorModel model, std::unique_ptr<const SpotTracker> tracker)
      : model_(std::move(model)), tracker_(std::move(tracker)) {}

  SensorModel model_;
  std::unique_ptr<const SpotTracker> tracker_;
  SensorConfig sensor_;
  ModeOperator slopes_;
  std::vector<Vec2> to_model_px_;  ///< per spot: model's flat position minus reference position
};

}  // namespace ovws::cli
