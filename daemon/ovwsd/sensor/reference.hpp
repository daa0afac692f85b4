/// The reference: where each spot is without the aberration to be measured, averaged over frames.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/spot.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/sensor/reference_picture.hpp"

namespace ovws {

/// What a reference belongs to: with anything else its positions mean nothing.
struct ReferenceKey {
  SensorConfig sensor;
  TrackingSettings tracking;
  Roi roi;
  friend bool operator==(const ReferenceKey&, const ReferenceKey&) = default;
};

/// `templates` matters to a tracker that has one only, `mode_operator` to no position.
ReferenceKey reference_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                           const Roi& roi);

enum class ReferenceSource {
  measured,  ///< averaged from frames
  model,     ///< where the configuration says that spots are: misalignment is in the coefficients
};
constexpr const char* reference_source_name(ReferenceSource source) {
  return source == ReferenceSource::model ? "model" : "measured";
}

struct Reference {
  ReferenceKey key;
  ReferenceSource source = ReferenceSource::measured;
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  std::optional<Registration> registration;  ///< in force while it was taken
  std::vector<Mode> aberration;              ///< shown while it was taken, RMS-normalised waves
  std::vector<Mode> introduced;  ///< the part of it that was introduced, not a correction
  std::vector<Vec2> positions_px;
  std::vector<Vec2> standard_error_px;
  std::shared_ptr<const ReferencePicture> picture;  ///< none: too few frames, or long ago
  std::shared_ptr<const nlohmann::json> origin;     ///< see ReferenceBench; none: not of a daemon
  std::string sha256;                               ///< of the file that keeps it; empty: none does
};

/// Root sum square, RMS-normalised waves.
double rms_waves(const std::vector<Mode>& modes);

}  // namespace ovws
