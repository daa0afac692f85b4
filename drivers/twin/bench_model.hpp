/// Optical model of the bench with an SLM, from SLM to camera.
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_view.hpp"
#include "drivers/twin/optical_model.hpp"
#include "drivers/twin/pupil_field.hpp"
#include "drivers/twin/pupil_screen.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Optical model of the bench with an SLM. The intensity is |far field|^2.
class BenchModel : public OpticalModel {
 public:
  explicit BenchModel(const Config& config);

  void set_light(const Light& light) override;
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) override;
  void set_window(const Roi& window, const CameraGeometry& geometry) override;
  /// Fast if only the turbulence has changed since the last call, or the grey levels inside the
  /// pupil, or after `prepare`.
  Image<float> intensity(const Image<std::uint8_t>& grey) override;
  /// Computes what these grey levels need, as far as it does not depend on the turbulence.
  void prepare(const Image<std::uint8_t>& grey) override;

  /// In the order of the lattice; empty if the configured lattice is not possible.
  std::vector<Vec2> true_spots_px(const Truth& truth) const override;
  double photons_per_peak_photon(const CameraGeometry& geometry) const override;
  std::unique_ptr<Judge> make_judge() const override;

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

  const Config config_;
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

}  // namespace ovws::twin
