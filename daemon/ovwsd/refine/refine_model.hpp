/// Maximum-likelihood refinement of live frames. Caches the refiner and the refined reference,
/// which are expensive, and rebuilds them when sensor, image, reference or camera parameters
/// change.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/sensor/refined_modes.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/refine_setup.hpp"

namespace ovws {

struct RefinedFrame {
  std::optional<RefinedModes> modes;  ///< minus the reference's; none: the fit found no minimum
  std::string refusal;                ///< why the result is not valid, for a person; empty: it is
  bool against_reference = false;     ///< else relative to the model
  double duration_ms = 0.0;           ///< of this frame's fit
};

/// One thread at a time.
class RefineModel {
 public:
  /// Once `stop` is true, a fit soon ends with a refusal; `stop` must outlive this object.
  RefineModel(const SlmGeometry& slm, const std::atomic<bool>& stop);
  ~RefineModel();

  /// `sensor`: the one that the frame was measured with. `settings` must have electrons_per_dn.
  /// Takes seconds, and longer for the first frame of a sensor or of a reference.
  RefinedFrame refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                      const RefineSetup& settings);

 private:
  struct Bench;
  struct RefinedReference;
  Result<void> make_bench(const FrameCopy& frame, const SensorSnapshot& sensor,
                          const RefineSetup& settings);
  const Result<RefinedModes>& refined_reference(const Reference& reference,
                                                const RefineSetup& settings);
  Result<RefinedModes> refine_picture(const Reference& reference, const RefineSetup& settings);

  SlmGeometry slm_;
  const std::atomic<bool>& stop_;
  std::unique_ptr<Bench> bench_;
  std::unique_ptr<RefinedReference> reference_;
};

}  // namespace ovws
