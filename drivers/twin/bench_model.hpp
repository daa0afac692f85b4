/// Optical model from SLM to camera: the intensity on each pixel of a window of the sensor.
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_view.hpp"
#include "drivers/twin/pupil_field.hpp"
#include "drivers/twin/pupil_screen.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Optical model of the bench. Use it in one thread at a time.
class BenchModel {
 public:
  explicit BenchModel(const Config& config);

  void set_aberration(std::span<const Mode> modes, std::span<const Shade> shades = {},
                      std::span<const LightVortex> branch_points = {});
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns);
  /// Sets the camera's region, in sensor pixels. The region may extend beyond the sensor.
  void set_window(const Roi& window, const CameraGeometry& geometry);

  /// Intensity |far field|^2 in the window, in units of the brightest pixel of an ideal charge-1
  /// spot. Call set_window first. Fast if only the turbulence has changed since the last call, or
  /// the grey levels inside the pupil, or after `prepare`.
  Image<float> intensity(const Image<std::uint8_t>& grey);
  /// Computes what the grey levels that come next need, as far as it does not depend on the
  /// turbulence. Call set_window first.
  void prepare(const Image<std::uint8_t>& grey);
  /// Complex far field F = sum exp(i phase) exp(-2 pi i (u x + v y)) up to its sign. The reference
  /// is valid until the next call. Call set_window first.
  const Image<std::complex<float>>& field(const Image<std::uint8_t>& grey);

 private:
  /// What depends on the grey levels, for the present aberration and window.
  struct Shown {
    Image<std::uint8_t> grey;          ///< empty: nothing is known
    Image<std::complex<float>> light;  ///< of PupilField
    /// Far field of the light beside the pupil.
    std::shared_ptr<const Image<std::complex<float>>> beside_pupil;
    Image<float> still;  ///< intensity without turbulence; may be empty
  };
  void show(const Image<std::uint8_t>& grey);
  void propagate_light(const Image<std::uint8_t>& grey, Shown& shown);
  std::shared_ptr<const Image<std::complex<float>>> propagate_beside(
      const Image<std::uint8_t>& grey);
  void propagate_to_grid(const Shown& shown);
  template <class Work>
  void for_pixel_rows(const Work& work) const;
  Image<float> intensity_of(const Shown& shown);

  Config config_;
  SlmModel slm_;
  double unit_;  ///< |far field|^2 in the brightest pixel of an ideal charge-1 spot
  std::optional<PupilScreen> screen_;  ///< turbulence
  std::optional<CameraView> view_;
  std::optional<PupilField> pupil_;
  bool lit_ = false;                   ///< pupil_ has the present light
  std::optional<FarField> far_field_;  ///< of the light beside the pupil
  Shown shown_, next_;
  Image<std::complex<float>> far_, pixel_field_;
};

/// Expected spot positions of the configured sensor, in pixels of the camera's sensor, for the
/// geometry and aberration of `truth`: by V-tilt for vortices, by G-tilt for bright spots.
/// Aberrations that the shown hologram adds are not included. In the order of the lattice; empty if
/// the configured lattice is not possible.
std::vector<Vec2> true_spots_px(const Config& config, const Truth& truth);

}  // namespace ovws::twin
