/// Refinement of live frames: the spots of each are rendered again until they fit. Keeps the model
/// and its reference, and makes them again when sensor, image, reference or camera change.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/sensor/refined_modes.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

namespace ovws {

struct RefinedFrame {
  std::optional<RefinedModes>
      modes;            ///< minus the reference's; none: the spots do not look as rendered
  std::string refusal;  ///< why the result is not valid, for a person; empty: it is
  bool against_reference = false;  ///< else relative to the model
  double duration_ms = 0.0;        ///< of this frame's fit
};

/// One thread at a time.
class RefineModel {
 public:
  explicit RefineModel(const SlmGeometry& slm);
  ~RefineModel();

  /// `sensor`: the one that the frame was measured with. `settings` must have electrons_per_dn.
  /// Takes tens of milliseconds, and some tenths of a second for the first frame of a sensor or of
  /// a reference.
  RefinedFrame refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                      const RefineSetup& settings);

 private:
  struct Bench;
  Result<void> make_bench(const FrameCopy& frame, const SensorSnapshot& sensor,
                          const RefineSetup& settings);

  SlmGeometry slm_;
  std::unique_ptr<Bench> bench_;
};

}  // namespace ovws
