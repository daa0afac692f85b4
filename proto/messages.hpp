/// What clients see on the streams, as plain structs; encode.hpp turns them into bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// `ovws.wavefront/1`. Spans are borrowed until the message is encoded.
struct WavefrontMessage {
  std::uint64_t seq = 0, frame_id = 0, gap = 0;
  std::int64_t t_device_ns = 0, t_arrival_ns = 0, t_publish_ns = 0;
  double latency_us = 0.0;
  std::uint64_t hologram_id = 0;
  bool settled = false;
  int charge = 1;
  std::string_view tracker;
  int subapertures = 0, tracked = 0;
  bool valid = false;
  double wavelength_nm = 632.0;
  std::span<const int> j;
  std::span<const float>
      coefficients;  ///< waves, RMS-normalised; each null in the message if not valid
  std::optional<double> rms_waves, fit_residual_px;
  std::optional<double> gain_db, exposure_us;  ///< none: not known for this very frame
  double saturated = 0.0;
  bool loop_closed = false;
};

/// `ovws.spots/1`: the binary part is N x 6 float32.
struct SpotsMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0;
  bool settled = false;
  std::span<const SpotFix> spots;
  std::span<const Vec2> reference_px;  ///< empty: NaN in the binary part
};

/// `ovws.image/1` and `ovws.phase/1`: the binary part is the rows of the picture.
struct ImageMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0;
  ImageView image;  ///< sent without padding
};
struct PhaseMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0;
  bool valid = false;
  const Image<float>* waves = nullptr;  ///< NaN outside the pupil
};

}  // namespace ovws
