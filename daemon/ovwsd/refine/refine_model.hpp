/// The refinement of one live frame: keeps what is dear to make, and makes it anew when the sensor,
/// the image, the reference or what is known of the camera changed.
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
  std::optional<RefinedModes> modes;  ///< minus the reference's; none: no minimum was found
  std::string refusal;                ///< why it is not valid, for a person; empty: it is
  bool against_reference = false;     ///< else against the model
  double duration_ms = 0.0;           ///< of this frame's fit
};

/// One thread at a time.
class RefineModel {
 public:
  /// Once `stop` is true a fit ends soon, refused; it must outlive this.
  RefineModel(const SlmGeometry& slm, const std::atomic<bool>& stop);
  ~RefineModel();

  /// `sensor`: that which the frame was measured with. `settings` with electrons_per_dn. Takes
  /// seconds; the first frame of a sensor and of a reference some more.
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
