/// Offline measurement of image files, with the code that measures the daemon's frames.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "core/spots/point_model.hpp"
#include "core/tracking/acquisition.hpp"
#include "daemon/ovwsd/sensor/refined_modes.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws::cli {

/// A greyscale image of 8 or 16 bits.
struct Picture {
  Image<std::uint8_t> narrow;
  Image<std::uint16_t> wide;  ///< one of the two is empty
  ImageView view() const;
};
/// Reads a PNG, TIFF or PGM file. Errors (Errc::invalid, field "image"): unreadable, or not
/// greyscale with 8 or 16 bits.
Result<Picture> read_image(const std::string& path);

/// The measurement of one image.
struct Measured {
  std::vector<SpotFix> spots;  ///< one per subaperture
  int tracked = 0;
  double saturated = 0.0;           ///< fraction of spots
  std::vector<float> coefficients;  ///< waves, order of the plan's modes_j; NaN if not measured
  std::vector<float> sigma_waves;   ///< standard errors; NaN unless `fitted`
  Reconstruction reconstruction;
  bool explained = true;  ///< false: determined, but no wavefront explains the spots
  bool valid = false;
  bool fitted = false;  ///< by all pixels of the spots (tracker `fit`), else by positions
  std::optional<RefinedModes> refined{};  ///< with a known camera
  std::string refused;                    ///< why a refined image is not valid; empty: it is
  OperatorReport mode_operator;           ///< the operator that gave the coefficients
};

/// Measures images of one size. One thread at a time.
class Measurement {
 public:
  /// `reference`: an image taken without aberration; none: positions come from the model. With a
  /// `camera`, `fit` assumes its noise, else that which the image shows; images are then refined,
  /// or not measured. Errors: an unusable configuration; a reference image of another size or with
  /// missing spots (named in the error), or which `fit` cannot explain; an operator that cannot be
  /// made.
  static Result<Measurement> make(const Config& config, const ImageView& like,
                                  const std::optional<ImageView>& reference,
                                  const std::optional<RefineCamera>& camera = std::nullopt);

  /// Searches every spot without history (Acquisition); `fit` then finds the wavefront from all
  /// pixels (PointModel). An image of another size gives no spots.
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
  bool by_positions(Measured& measured);
  std::unique_ptr<MeasurementPlan> plan_;
  std::optional<PointModel> model_;  ///< of the tracker `fit`
  std::optional<RefineCamera> camera_;
  bool counts_from_image_ = false;  ///< else from the model
  Acquisition acquisition_;
  TrackScratch track_scratch_;
  Reconstructor::Scratch solve_scratch_;
};

}  // namespace ovws::cli
