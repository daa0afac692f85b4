/// Refinement of live frames: renders the spots again until they fit the frame's pixels. Caches the
/// model, and rebuilds it when sensor, image size, reference or refinement settings change.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/fitter/refined_modes.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

/// Whether a frame can be refined: its hologram had settled, its camera settings are known, and it
/// is valid or the sensor has no reference.
bool can_be_refined(const FrameRecord& record);

struct RefinedFrame {
  std::optional<RefinedModes> modes;  ///< none: not fitted, see `refusal`
  std::string refusal;  ///< reason for the user why the result is not valid; empty: valid
  bool against_reference = false;  ///< modes are minus the reference's; false: absolute
  double duration_ms = 0.0;        ///< duration of the fit
};

/// Model for the live refinement. Not thread-safe.
class RefineModel {
 public:
  explicit RefineModel(const SlmGeometry& slm);
  ~RefineModel();

  /// Refines one frame. `sensor`: the sensor state with which the frame was measured. `settings`
  /// must have electrons_per_dn. A fit takes some 0.1 ms while the templates of an earlier frame
  /// are exact, else tens of milliseconds; the first frame with a new sensor or reference, and
  /// every frame without a reference, take some tenths of a second.
  RefinedFrame refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                      const RefineSetup& settings);
  /// The next frame is refined without the templates of an earlier one.
  void forget_frames();

 private:
  struct Bench;
  Result<void> make_bench(const FrameCopy& frame, const SensorSnapshot& sensor,
                          const RefineSetup& settings);

  SlmGeometry slm_;
  std::unique_ptr<Bench> bench_;
};

}  // namespace ovws
