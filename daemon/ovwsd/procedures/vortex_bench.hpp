/// Images of one vortex that fills the pupil, its axis at several places, for focus.run.
#pragma once

#include <optional>
#include <vector>

#include "core/wavefront/vortex_path.hpp"
#include "daemon/ovwsd/procedures/probe_bench.hpp"

namespace ovws {

/// Shows the vortex and takes its images, in the thread of one procedure. The whole pupil's spot is
/// hundreds of times as bright as the sensor's. The exposure is shortened for it, and where the
/// camera cannot go on, the depth of the hologram's phase (Probe::depth).
class VortexBench {
 public:
  /// `probe_diameter_px`: of a bright spot that the present exposure suits, SLM pixels.
  /// `middle_px`: where the beam is expected, camera pixels. Averages `frames` frames for each
  /// image.
  VortexBench(Bench& bench, const SlmGeometry& slm, const SensorSnapshot& now, int frames,
              double probe_diameter_px, Vec2 middle_px);

  const VortexBeam& beam() const { return beam_; }
  /// Takes an image at each of vortex_axes() with `shown` (RMS-normalised waves) added to the
  /// hologram. `from` .. `to`: share of the job's progress. Errors: those of ProbeBench::light;
  /// Errc::refused, field "camera.exposure_us": the vortex is saturated or too dark at every
  /// exposure that the camera allows.
  Result<std::vector<VortexImage>> images(const std::vector<Mode>& shown, double from, double to);

 private:
  /// The brightest pixel near the middle as a fraction of full scale; NaN: saturated.
  double brightest(const Image<float>& light) const;
  Result<void> change_brightness(double factor);
  /// Takes the images; none: the brightness was changed, and they must be taken again.
  Result<std::optional<std::vector<VortexImage>>> try_images(Probe probe, double from, double to);

  Bench& bench_;
  int frames_;
  Vec2 base_cpp_, middle_px_;
  VortexBeam beam_;
  std::optional<double> first_factor_;  ///< on the brightness, before the first image
  double depth_ = 1.0;
  std::optional<ProbeBench> probes_;  ///< for the present exposure
};

}  // namespace ovws
