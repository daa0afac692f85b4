/// Settings of the live refinement, on the wire and in the configuration.
#pragma once

#include "core/control/refine_settings.hpp"

namespace ovws {

/// RefineSettings, and what the model fits besides the modes.
struct RefineSetup : RefineSettings {
  bool spot_amplitudes = false;  ///< fit each subaperture's amplitude (uneven illumination)

  friend bool operator==(const RefineSetup&, const RefineSetup&) = default;
};

/// Whether both settings give the same fit.
inline bool same_fit(const RefineSetup& a, const RefineSetup& b) {
  return a.spot_amplitudes == b.spot_amplitudes && same_camera(a, b);
}

/// Converts numbers in DN to another pixel format, as the overload for RefineSettings does.
inline RefineSetup in_format(RefineSetup setup, PixelFormat format) {
  RefineSettings& camera = setup;
  camera = in_format(camera, format);
  return setup;
}

}  // namespace ovws
