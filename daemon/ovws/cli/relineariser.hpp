/// Modes of an image file by steps from where the diffraction model puts the spots.
#pragma once

#include <memory>
#include <vector>

#include "config/config.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/mode_operator.hpp"
#include "core/wavefront/relinearise.hpp"

namespace ovws::cli {

/// For images of one size. A tenth of a second an image; one thread at a time.
class Relineariser {
 public:
  /// `measured`: the plan's reference is that of an image, and displacements count from it as they
  /// would from the model's flat sensor; else positions are the model's own. Errors: as of
  /// SensorModel::make and make_tracker; Errc::refused for a camera that is not straight.
  static Result<Relineariser> make(const Config& config, const MeasurementPlan& plan,
                                   bool measured);

  /// Spots in `torn` are left out: the tracker does not see them where they are. Errors as of
  /// relinearise; Errc::refused if the steps do not come to rest.
  Result<Relinearised> measure(const std::vector<SpotFix>& spots, const std::vector<int>& torn,
                               const std::vector<float>& linear);

 private:
  Relineariser(SensorModel model, std::unique_ptr<const SpotTracker> tracker)
      : model_(std::move(model)), tracker_(std::move(tracker)) {}

  SensorModel model_;
  std::unique_ptr<const SpotTracker> tracker_;
  SensorConfig sensor_;
  ModeOperator slopes_;
  std::vector<Vec2> to_model_px_;  ///< from a measured reference to the model's, by spot
};

}  // namespace ovws::cli
