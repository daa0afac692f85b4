/// Where the templates of the tracker `fit` come from: the diffraction model, and a calibration.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/spots/measured_model.hpp"
#include "core/spots/point_model.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// The noise of a frame, DN of the format.
using FrameNoise = std::function<std::pair<PixelNoise, PixelFormat>(PointModel&)>;

/// The wavefront of these spots against the model, by the slopes of their positions, for the modes
/// of the plan; 0 for modes that positions do not determine. None: too few spots are found.
std::optional<std::vector<double>> modes_against_model(const SensorSnapshot& sensor,
                                                       const SlmGeometry& slm, int cols, int rows,
                                                       std::span<const SpotFix> spots);

/// The diffraction model of the sensor's spots, and of its reference. Errors: those of
/// SpotRenderer::make and PointModel::use_reference; Errc::refused, field "reference": it has no
/// mean image, or too few of its spots are known.
Result<PointModel> rendered_model(const SensorSnapshot& sensor, const SlmGeometry& slm, int cols,
                                  int rows, const FrameNoise& frame_noise);

/// Templates of a calibration are exact for this bench, but only near the wavefront that it was
/// measured at; rendered ones follow any wavefront, and are as exact as the model of the bench.
class SpotsModel {
 public:
  /// Of the sensor's reference, and of its calibration if that is active. `images`: present frames,
  /// which give the noise. Errors, if neither can be used: those of SpotRenderer::make,
  /// PointModel::use_reference and MeasuredModel::use_reference; Errc::refused, field "reference":
  /// it has no mean image, or too few of its spots are known; field "calibration": its spots lie
  /// outside the image.
  static Result<SpotsModel> make(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                 std::span<const ImageView> images);

  /// Those that the calibration measured, if the last of `images` is within their reach; else null.
  std::shared_ptr<const FrameFit> measured_near(std::span<const ImageView> images) const;
  bool has_measured() const { return measured_.has_value(); }
  /// Why an active calibration is not used; empty: it is used, or there is none.
  const std::string& unmeasured() const { return unmeasured_; }

  /// Templates about the wavefront of the last of `images`, looked for from each of `starts` in
  /// turn; the images before it give the noise. Those of the calibration, if they are near, or if
  /// nothing else describes the image. `fixed`: modes shown that are not measured. Errors: those of
  /// PointModel::templates and MeasuredModel::templates.
  Result<std::shared_ptr<const FrameFit>> templates(std::span<const ImageView> images,
                                                    std::span<const std::vector<double>> starts,
                                                    std::span<const Mode> fixed, int renderings);

 private:
  SpotsModel() = default;

  std::optional<PointModel> rendered_;  ///< none: the model does not explain the reference
  std::optional<MeasuredModel> measured_;
  std::string unmeasured_;
};

/// When the calibration was taken whose measured templates are active; 0: none.
std::int64_t active_calibration_ns(const SensorSnapshot& sensor);

/// Modes on the SLM that are not measured.
std::vector<Mode> fixed_modes(const std::vector<Mode>& shown, const std::vector<int>& measured);

}  // namespace ovws
