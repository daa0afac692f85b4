/// What the live refinement is told, on the wire and in the configuration.
#pragma once

#include "core/control/refine_settings.hpp"

namespace ovws {

/// RefineSettings, and what the model fits beside the modes.
struct RefineSetup : RefineSettings {
  bool spot_amplitudes = false;  ///< each subaperture's: uneven illumination

  friend bool operator==(const RefineSetup&, const RefineSetup&) = default;
};

/// Whether a fit by either is the same.
inline bool same_fit(const RefineSetup& a, const RefineSetup& b) {
  return a.spot_amplitudes == b.spot_amplitudes && same_camera(a, b);
}

/// As that of RefineSettings, which knows the camera only.
inline RefineSetup in_format(RefineSetup setup, PixelFormat format) {
  RefineSettings& camera = setup;
  camera = in_format(camera, format);
  return setup;
}

}  // namespace ovws
