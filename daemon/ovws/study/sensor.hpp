/// The sensor of a study: light by diffraction, the detector's noise, spots by a tracker, modes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws::study {

constexpr int kImagePx = 512;  ///< the camera's image, each way

/// The bench that is simulated.
struct Geometry {
  SlmGeometry slm;
  OpticsConfig optics;
  SensorConfig sensor;
};
Geometry default_bench();      ///< the paper's bench
Geometry thousand_px_bench();  ///< the paper's simulation: a pupil of 1000 px

constexpr double kPeakE = 500.0;  ///< electrons in the brightest pixel at equal peak
/// Peak SNR: P / sqrt(P + sigma^2), shot noise of the peak and read noise together.
double snr_of_read_noise(double read_noise_e);
double read_noise_of_snr(double snr);

/// Which light two sensors are compared at.
enum class Light {
  equal_peak,    ///< kPeakE in the spots' brightest pixel: the camera's full well is the limit
  equal_photons  ///< as many photons as the vortex sensor's image has at equal peak
};
const char* name_of(Light light);

/// An image of the detector, 16 bit. The black level lies four times the read noise above zero, so
/// that nothing is clipped.
struct Exposure {
  Image<std::uint16_t> dn;
  double black_dn = 0.0;
  double dn_per_e = 8.0;
  ImageView view() const { return view_of(dn, PixelFormat::mono16); }
  /// The same realisation with its black level taken off and clipped at zero: what a plain centroid
  /// is given.
  Exposure clipped() const;
};
Exposure noise_free(const Image<float>& electrons);
Exposure expose(const Image<float>& electrons, double read_noise_e, std::uint64_t seed);

/// One way to measure: a charge, a tracker.
struct Method {
  std::string name;
  int charge = 1;
  TrackingConfig tracking;
  /// The text-book Shack-Hartmann sensor: the centroid of a fixed cell around the reference, as
  /// wide as the pitch, whatever the starts; `tracking` then only tells the slopes' model.
  bool fixed_cell = false;
};
std::vector<Method> all_methods();  ///< every tracker that makes sense for charges 1 and 0

/// A sensor of one charge with one tracker, referenced on its own noise-free image of a flat
/// wavefront. Immutable but for `light`: measuring is thread-safe.
class Measurer {
 public:
  Measurer(const Geometry& geometry, const Method& method, std::shared_ptr<SensorModel> model);

  const Method& method() const { return method_; }
  int spots() const { return int(reference_px_.size()); }
  const std::vector<Vec2>& reference_px() const { return reference_px_; }
  const Lattice& lattice() const { return model_->lattice(); }
  double lambda_d_px() const { return model_->lambda_d_px(); }
  const SpotTracker& tracker() const { return *tracker_; }
  const std::vector<int>& modes_j() const { return reconstructor_->modes_j(); }
  const Eigen::MatrixXd& slopes() const { return slopes_; }  ///< as of slope_matrix

  /// One fix a spot, each searched from its start. Thread-safe.
  std::vector<SpotFix> track(const Exposure& exposure, std::span<const Vec2> starts_px) const;
  /// Waves, in the order of modes_j; NaN if too few spots were found.
  std::vector<double> modes(std::span<const SpotFix> spots) const;
  /// Where the spots are without noise, tracked from `near_px`. `light` in electrons.
  std::vector<Vec2> noise_free_px(const Image<float>& light, std::span<const Vec2> near_px) const;
  /// The first-order positions with these modes shown.
  std::vector<Vec2> predicted_px(std::span<const Mode> modes) const;

 private:
  std::vector<SpotFix> cell_centroids(const Exposure& exposure) const;

  Method method_;
  std::shared_ptr<SensorModel> model_;
  std::unique_ptr<const SpotTracker> tracker_;
  std::vector<Vec2> reference_px_;
  int cell_half_px_ = 0;
  Eigen::MatrixXd slopes_;
  std::unique_ptr<const Reconstructor> reconstructor_;
};

/// Geometry with the method's charge.
std::shared_ptr<SensorModel> model_of(Geometry geometry, int charge);
/// Electrons with these modes shown, scaled as `light` says; `vortex` is the charge-1 model.
Image<float> electrons(SensorModel& model, SensorModel& vortex, std::span<const Mode> modes,
                       Light light);

}  // namespace ovws::study
