/// Rendering: the expected image of every spot for a given wavefront, with its derivatives.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/piece_moments.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/spots/operating_point.hpp"
#include "core/spots/rendered_spot.hpp"
#include "core/spots/spot_correction.hpp"

namespace ovws {

/// Spot renderer: diffraction model of the whole SLM (SensorField). In the derivatives a
/// subaperture contributes to its own window and to its neighbours', and every mode is a polynomial
/// of degree 3 over a subaperture (PieceMoments). Use it from one thread at a time, off the frame
/// path: a rendering takes some 10 ms on the default bench.
class SpotRenderer {
 public:
  struct Options {
    double half_width = 0.0;    ///< half the width of a window, lambda/d; 0: window_half_width
    double reach = 6.0;         ///< distance up to which subapertures are neighbours, lambda/d
    bool light_outside = true;  ///< also render the field outside the subapertures
    LitPixels lit{};            ///< camera pixels that the laser reaches
  };

  /// `cols` x `rows`: size of the camera image. Errors: those of SensorField::make, and
  /// Errc::invalid, field "optics", if a window does not fit into the image; Errc::refused, field
  /// "tracking.mode_count", if the derivatives of all spots do not fit into memory.
  static Result<SpotRenderer> make(const SensorConfig& sensor, const SlmGeometry& slm,
                                   const OpticsConfig& optics, int cols, int rows,
                                   std::vector<int> modes_j, const Options& options);

  const std::vector<int>& modes_j() const { return modes_j_; }
  int spots() const { return field_.subapertures(); }
  /// Centre of a spot's subaperture, in pupil radii.
  Vec2 centre(int spot) const {
    return field_.cells().in_pupil(field_.cells().pieces[std::size_t(spot)].centre_px);
  }

  /// Displacement of a spot per wave of tilt at the edge of its subaperture, camera pixels.
  double px_per_wave(int spot) const {
    return 1.0 / (field_.window().step_cpp * field_.cells().pieces[std::size_t(spot)].radius_px);
  }

  /// Sets the deviations of the bench. Ends the correction, which is relative to them.
  void set_deviations(SpotDeviations deviations) {
    deviations_ = std::move(deviations);
    correction_.reset();
  }
  const SpotDeviations& deviations() const { return deviations_; }

  /// Corrects later renderings; none: no longer.
  void set_correction(std::optional<SpotCorrection> correction) {
    correction_ = std::move(correction);
  }
  /// Size of the windows; its position has no meaning.
  const SpotWindow& window_size() const { return window_; }
  /// Intensity of the binned pixels in the windows of `spots`, without correction.
  std::vector<Eigen::VectorXf> light_in(std::span<const RenderedSpot> spots,
                                        std::span<const double> waves, std::span<const Mode> fixed);

  /// Derivatives of each binned pixel with respect to the field over the spot's own subaperture:
  /// first the real, then the imaginary parts of its LocalField coefficients. `rendered` must be
  /// the last rendering, of `waves` and `fixed`.
  std::vector<Eigen::MatrixXf> per_field(std::span<const RenderedSpot> rendered,
                                         std::span<const double> waves,
                                         std::span<const Mode> fixed);

  /// Renders every spot about the wavefront `waves` (RMS-normalised, one for each of modes_j) plus
  /// `fixed` (other modes on the SLM, such as introduced ones). Windows stay inside the image.
  std::vector<RenderedSpot> render(std::span<const double> waves, std::span<const Mode> fixed = {});

 private:
  SpotRenderer(SensorField field, std::vector<int> modes_j, SpotWindow window, double reach_px);
  void propagate(std::span<const Mode> modes, std::span<const SensorField::LocalField> fields);
  FarPoints middles_of(const SpotWindow& window) const;
  Eigen::VectorXf intensity_in(const SpotWindow& window) const;
  Eigen::MatrixXcf field_of_cells(const RenderedSpot& spot, Vec2 centre_px) const;
  void add_derivatives(RenderedSpot& spot, const Eigen::MatrixXcf& far, int piece, bool own);

  SensorField field_;
  SpotDeviations deviations_;
  std::optional<SpotCorrection> correction_;
  std::vector<int> modes_j_;
  PieceMoments moments_;
  SpotWindow window_;  ///< size of every window
  double reach_px_;
  double to_intensity_ = 1.0;  ///< factor from |F|^2 of a camera pixel to intensity
};

}  // namespace ovws
