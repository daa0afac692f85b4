/// Images of any lab through the code that measures the daemon's frames.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/shaped_acquisition.hpp"
#include "daemon/ovws/cli/relineariser.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws::cli {

/// A grey picture of 8 or 16 bit.
struct Picture {
  Image<std::uint8_t> narrow;
  Image<std::uint16_t> wide;  ///< one of the two is empty
  ImageView view() const;
};
/// PNG, TIFF, PGM. Errors (Errc::invalid, field "image"): unreadable, or not grey of 8 or 16 bit.
Result<Picture> read_picture(const std::string& path);

/// What one image told.
struct Measured {
  std::vector<SpotFix> spots;  ///< one a subaperture
  std::vector<int> torn;  ///< of the found, those placed by the shape that the wavefront gives them
  int tracked = 0;
  double saturated = 0.0;           ///< fraction of spots
  std::vector<float> coefficients;  ///< waves, order of the plan's modes_j; NaN if not valid
  Reconstruction reconstruction;
  bool explained = true;  ///< false: no wavefront explains the spots, else it were valid
  bool valid = false;
  OperatorReport mode_operator;  ///< what made the coefficients of the positions
};

/// For images of one size. One thread at a time.
class Measurement {
 public:
  /// `reference`: an image taken without aberration; none: the model's positions are the reference,
  /// and the template. Templates of a reference are those of this very image.
  /// Errors: a configuration that makes no sensor; a reference image of another size, or in which
  /// spots are missing (they are named); an operator that cannot be made.
  static Result<Measurement> make(const Config& config, const ImageView& like,
                                  const std::optional<ImageView>& reference);

  /// Every spot is searched without history, torn ones too (ShapedAcquisition). An image of another
  /// size has none.
  Measured measure(const ImageView& image);
  const MeasurementPlan& plan() const { return *plan_; }
  const TemplateReport& templates() const { return templates_; }

 private:
  Measurement(const Config& config, std::unique_ptr<MeasurementPlan> plan,
              TemplateReport templates = {});
  void relinearise(Measured& measured);
  std::unique_ptr<MeasurementPlan> plan_;
  TemplateReport templates_;
  std::optional<Relineariser> relineariser_;
  ShapedAcquisition acquisition_;
  TrackScratch track_scratch_;
  Reconstructor::Scratch solve_scratch_;
};

}  // namespace ovws::cli
