/// Template sources for the tracker `fit`: the diffraction model and a calibration.
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
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// All that a model of the sensor's spots in frames like this one depends on, besides the noise of
/// the pixels and the calibration.
struct ModelKey {
  std::uint64_t sensor_epoch = 0;
  int cols = 0, rows = 0;
  LitPixels lit;
  std::vector<int> modes_j;
  int estimates = 0;                    ///< number of estimates from each spot
  std::int64_t reference_taken_ns = 0;  ///< 0: no reference

  /// `sensor`: the sensor state with which the frame was measured.
  ModelKey(const FrameCopy& frame, const SensorSnapshot& sensor);
  friend bool operator==(const ModelKey&, const ModelKey&) = default;
};

/// Returns the pixel noise of a frame, in DN of the pixel format that is returned with it.
using FrameNoise = std::function<std::pair<PixelNoise, PixelFormat>(PointModel&)>;

/// Modes of the plan, reconstructed from the displacements of `spots` from the model's positions.
/// Modes that positions do not determine are 0. None: too few spots are found.
std::optional<std::vector<double>> modes_against_model(const SensorSnapshot& sensor,
                                                       const SlmGeometry& slm, int cols, int rows,
                                                       std::span<const SpotFix> spots);

/// Diffraction model of the sensor's spots in images like `like`, fitted to the mean image of its
/// reference, if the reference is measured. Errors: those of SpotRenderer::make and
/// PointModel::use_reference; Errc::refused, field "reference": it has no mean image, too few known
/// spots, or other colour filters than `like`.
Result<PointModel> rendered_model(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                  const ImageView& like, const FrameNoise& frame_noise);

/// Chooses between measured and rendered templates. Measured templates come from a calibration:
/// they are exact for this bench, but only near the calibration's wavefront. Rendered templates
/// follow any wavefront, and are as exact as the model of the bench; not far from the calibration,
/// it corrects them.
class SpotsModel {
 public:
  /// Makes the models from the sensor's reference and, if active, its calibration. `images`:
  /// present frames, which give the noise. Errc::refused, field "reference": it has no mean image.
  /// Errors if neither model can be used: those of rendered_model without an active calibration;
  /// with one, Errc::refused, field "reference", and the reason why the calibration cannot be used.
  static Result<SpotsModel> make(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                 std::span<const ImageView> images);

  /// Replaces the calibration by the sensor's active one, if any; the reference is that of `make`.
  /// Errors as those of `make`.
  Result<void> use_calibration(const SensorSnapshot& sensor, std::span<const ImageView> images);

  /// Measured templates, if the wavefront of the last of `images` is within 0.02 wave RMS of the
  /// calibration's wavefront; else null.
  std::shared_ptr<const FrameFit> measured_near(std::span<const ImageView> images) const;
  /// Call when the camera's gain or exposure has changed.
  void forget_noise() {
    if (rendered_) rendered_->forget_noise();
  }
  bool has_measured() const { return measured_.has_value(); }
  bool has_rendered() const { return rendered_.has_value(); }
  /// Why an active calibration is not used; empty: it is used, or no calibration is active.
  const std::string& unmeasured() const { return unmeasured_; }

  /// Templates about the wavefront of the last of `images`; the earlier images give the noise. Uses
  /// the measured templates if they are near, or if no rendered ones describe the image. Rendering
  /// begins at each of `starts` in turn, with at most `renderings` each. `fixed`: modes shown that
  /// are not measured. Errors: those of PointModel::templates and MeasuredModel::templates.
  Result<std::shared_ptr<const FrameFit>> templates(std::span<const ImageView> images,
                                                    std::span<const std::vector<double>> starts,
                                                    std::span<const Mode> fixed, int renderings);

 private:
  SpotsModel() = default;

  Result<PointModel> rendered_ = fail(Errc::refused, "reference", "");  ///< why it cannot be used
  std::optional<MeasuredModel> measured_;
  std::string unmeasured_;
};

/// Modes shown on the SLM that are not among the measured modes.
std::vector<Mode> fixed_modes(const std::vector<Mode>& shown, const std::vector<int>& measured);
/// Those that the sensor's hologram shows.
std::vector<Mode> fixed_modes(const SensorSnapshot& sensor);

}  // namespace ovws
