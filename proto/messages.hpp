/// Stream messages as plain structs; encode.hpp turns them into bytes.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/pipeline/verdict.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// Fields common to `wavefront`, `spots` and `corrector`: the frame and how it was measured.
/// Strings and spans in messages are borrowed until the message is encoded.
struct FrameMessage {
  std::uint64_t seq = 0, frame_id = 0, gap = 0;
  std::int64_t t_device_ns = 0, t_arrival_ns = 0, t_publish_ns = 0;
  double latency_us = 0.0;
  std::uint64_t hologram_id = 0;
  bool settled = false;
  std::optional<int> pattern;  ///< of a DMD's sequence; none: none is shown, or it is uncertain
  int charge = 1;
  std::string_view tracker;
  int subapertures = 0, tracked = 0;
  bool valid = false;
  Verdict verdict = Verdict::changing;
  double wavelength_nm = 632.0;
  std::optional<double> rms_waves,
      fit_residual_px;  ///< rms_waves is encoded as null if not valid
  std::optional<double> gain_db, gain_raw, exposure_us;  ///< none: unknown for this frame
  double saturated = 0.0;
  bool loop_closed = false;
  double reference_introduced_rms_waves = 0.0;  ///< introduced aberration within the reference
};

/// A phase singularity of the incoming light: [x, y, charge] in the wavefront message.
using BranchPointEntry = std::array<double, 3>;

/// `ovws.wavefront/1`.
struct WavefrontMessage : FrameMessage {
  std::span<const int> j;
  /// Waves, RMS-normalised, as many as `j`; all encoded as null if not valid.
  std::span<const float> coefficients;
  std::span<const float> sigma;  ///< standard errors, as many as `j`; all null if not `fitted`
  std::span<const BranchPointEntry> branch_points;  ///< empty: none recognised
  bool fitted = false;                              ///< true: measured from all pixels of the spots
};

/// `ovws.spots/1`: the binary part is N x 6 float32.
struct SpotsMessage : FrameMessage {
  std::span<const SpotFix> spots;
  std::span<const Vec2> reference_px;  ///< as many as `spots`; empty: NaN in the binary part
};

/// `ovws.corrector/1`: the binary part is one float32 per actuator, or absent if not valid.
struct CorrectorMessage : FrameMessage {
  int matrix = 0;                   ///< number of the matrix that made the commands
  std::span<const float> commands;  ///< empty if not valid
};

/// `ovws.refined/1`. Owns its data, because the message waits in a queue.
struct RefinedMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0, t_publish_ns = 0;
  int charge = 1;
  bool valid = false;
  std::string reason;              ///< why `valid` is false; empty if true
  bool against_reference = false;  ///< false: coefficients are relative to the model
  double wavelength_nm = 632.0;
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;
  std::vector<int> j;
  /// Waves, as many as `j`; all encoded as null if not valid.
  std::vector<double> coefficients, sigma;
  struct Fit {
    double chi2_per_pixel = 0.0, peak_e = 0.0, background_e = 0.0;
    int iterations = 0;
  };
  std::optional<Fit> fit;  ///< none: the fit found no minimum
  double duration_ms = 0.0;
};

/// `ovws.image/1` and `ovws.phase/1`: the binary part holds the rows of the image.
struct ImageMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0;
  std::optional<int> pattern;  ///< see FrameMessage
  ImageView image;             ///< sent without padding
};
struct PhaseMessage {
  std::uint64_t seq = 0, frame_id = 0, hologram_id = 0;
  std::int64_t t_arrival_ns = 0;
  bool valid = false;
  double wavelength_nm = 632.0;
  const Image<float>* waves = nullptr;  ///< NaN outside the pupil
};

enum class Severity { info, warning, error };

/// `ovws.event/1`.
struct EventMessage {
  std::uint64_t seq = 0;
  std::int64_t t_ns = 0;
  std::string kind;  ///< "state", "camera", "slm", "job", "config", …
  Severity severity = Severity::info;
  std::string text;     ///< one sentence for a person
  nlohmann::json data;  ///< for programs; its shape depends on the kind
};

}  // namespace ovws
