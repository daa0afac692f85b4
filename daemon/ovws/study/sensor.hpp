/// Simulated sensor of the studies: diffraction model, detector noise, tracker and reconstruction.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws::study {

constexpr int kImagePx = 512;         ///< width and height of the camera image
constexpr double kStartWithin = 0.3;  ///< lambda/d per axis: error of predicted positions
constexpr double kGross = 0.5;        ///< lambda/d: a larger error counts as a wrong spot

/// Unwraps a result. A study's own configuration is always valid, so an error is a bug and thrown.
template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::logic_error(text_of(result.error()));
  return std::move(*result);
}

/// OSA indices 1 to `count`.
std::vector<int> first_modes_j(int count);
/// Coefficients of the modes `modes_j`, waves, without the modes that are not among them.
std::vector<double> waves_of(std::span<const Mode> modes, const std::vector<int>& modes_j);

/// Bench geometry: configuration of the simulated bench.
struct Geometry {
  SlmGeometry slm;
  OpticsConfig optics;
  SensorConfig sensor;
};
Geometry default_bench();      ///< the paper's bench
Geometry thousand_px_bench();  ///< the paper's simulation: a pupil of 1000 px

constexpr double kPeakE = 500.0;  ///< electrons in the brightest pixel at equal peak
/// Peak SNR = P / sqrt(P + sigma^2), with the peak P = kPeakE and the read noise sigma in
/// electrons.
double snr_of_read_noise(double read_noise_e);
double read_noise_of_snr(double snr);

/// Normalisation of the light level at which two sensors are compared.
enum class Light {
  equal_peak,    ///< kPeakE in the spots' brightest pixel: the camera's full well is the limit
  equal_photons  ///< the same number of photons: the laser is the limit
};
NLOHMANN_JSON_SERIALIZE_ENUM(Light, {{Light::equal_peak, "equal peak"},
                                     {Light::equal_photons, "equal photons"}})
inline constexpr std::array kLights{Light::equal_peak, Light::equal_photons};
std::string name_of(Light light);
/// What the names of a figure's files end with.
const char* suffix_of(Light light);

/// A 16-bit detector image. The black level is four times the read noise, so that noise is not
/// clipped at zero.
struct Exposure {
  Image<std::uint16_t> dn;
  double black_dn = 0.0;
  double dn_per_e = 8.0;
  ImageView view() const { return view_of(dn, PixelFormat::mono16); }
  /// Copy of the exposure with the black level subtracted and negative values clipped at zero, as a
  /// plain centroid requires.
  Exposure clipped() const;
};
Exposure noise_free(const Image<float>& electrons);
Exposure expose(const Image<float>& electrons, double read_noise_e, std::uint64_t seed);

/// Centroids of all light in fixed windows of half the size `half_px`, as in the textbook
/// Shack-Hartmann sensor.
std::vector<SpotFix> cell_centroids(const Exposure& exposure, std::span<const Vec2> centres_px,
                                    int half_px);

/// A measurement method: charge and tracker.
struct Method {
  std::string name;
  int charge = 1;
  TrackingConfig tracking;
  /// Textbook Shack-Hartmann sensor: the centroid of a fixed window around the reference, as wide
  /// as the pitch. Start positions are ignored; `tracking` then only selects the slope model.
  bool fixed_cell = false;
};
std::vector<Method> all_methods();  ///< every tracker usable with charge 1 or 0

/// Sensor of one charge with one tracker. Its reference is its noise-free image of a flat
/// wavefront. Immutable, so that measuring is thread-safe.
class Measurer {
 public:
  Measurer(const Geometry& geometry, const Method& method, std::shared_ptr<SensorModel> model);

  const Method& method() const { return method_; }
  int spots() const { return int(reference_px_.size()); }
  const std::vector<Vec2>& reference_px() const { return reference_px_; }
  double lambda_d_px() const { return model_->lambda_d_px(); }
  const SpotTracker& tracker() const { return *tracker_; }
  const std::vector<int>& modes_j() const { return reconstructor_->modes_j(); }

  /// Tracks one spot from each start. The tracker `fit` uses PositionFit. Thread-safe.
  std::vector<SpotFix> track(const Exposure& exposure, std::span<const Vec2> starts_px) const;
  /// Modes in waves, in the order of modes_j; NaN if too few spots were found.
  std::vector<double> modes(std::span<const SpotFix> spots) const;
  /// Spot positions in the noise-free image, tracked from `near_px`. `light` in electrons.
  std::vector<Vec2> noise_free_px(const Image<float>& light, std::span<const Vec2> near_px) const;
  /// Spot positions predicted by the slope matrix (first order) for these modes.
  std::vector<Vec2> predicted_px(std::span<const Mode> modes) const;

 private:
  Method method_;
  std::shared_ptr<SensorModel> model_;
  std::unique_ptr<const SpotTracker> tracker_, position_fit_;
  std::vector<Vec2> reference_px_;
  int cell_half_px_ = 0;
  Eigen::MatrixXd slopes_;
  std::unique_ptr<const Reconstructor> reconstructor_;
};

/// Diffraction model of the bench `geometry` with this charge.
std::shared_ptr<SensorModel> model_of(Geometry geometry, int charge);

/// Diffraction models of one bench with vortices of charge 1 and with bright spots.
class SensorPair {
 public:
  explicit SensorPair(const Geometry& geometry)
      : vortex_(model_of(geometry, 1)), bright_(model_of(geometry, 0)) {}

  const std::shared_ptr<SensorModel>& of(int charge) const {
    return charge == 0 ? bright_ : vortex_;
  }
  /// Camera image in electrons per pixel with these modes on the SLM. At equal photons, bright
  /// spots have the photons that the vortices have at equal peak.
  Image<float> electrons(int charge, std::span<const Mode> modes, Light light) const;

 private:
  std::shared_ptr<SensorModel> vortex_, bright_;
};

}  // namespace ovws::study
