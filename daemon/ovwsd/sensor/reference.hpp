/// The reference: mean spot positions without the aberration to be measured.
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
#include "daemon/ovwsd/sensor/reference_image.hpp"

namespace ovws {

/// Settings that a reference depends on. If any setting differs from the present one, the
/// reference's positions must not be used.
struct ReferenceKey {
  SensorConfig sensor;
  TrackingSettings tracking;
  Roi roi;
  friend bool operator==(const ReferenceKey&, const ReferenceKey&) = default;
};

/// Settings that a reference depends on. Settings without effect on positions are set to constants:
/// operator, mode count, estimates and `templates`. Tracker `fit` is replaced by `lg`, because both
/// find equal positions.
ReferenceKey reference_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                           const Roi& roi);

/// Settings that a calibration depends on: those of reference_key, and with tracker `fit` also
/// `fit` itself and its mode count. A calibration with `fit` measures spot shapes, too, for as many
/// modes as requested.
ReferenceKey calibrated_sensor(const SensorConfig& sensor, const TrackingSettings& tracking,
                               const Roi& roi);

enum class ReferenceSource {
  measured,  ///< averaged from frames
  model,     ///< computed: coefficients then contain the bench's misalignment
};
constexpr const char* reference_source_name(ReferenceSource source) {
  return source == ReferenceSource::model ? "model" : "measured";
}

/// The part of a measured reference that belongs to a further light source.
struct BeamReference {
  std::string beam;  ///< name in the configuration
  Vec2 offset_px;    ///< as configured when it was taken
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  std::vector<Mode> aberration, introduced;  ///< as in Reference
  std::vector<Vec2> positions_px, standard_error_px;
};

struct Reference {
  ReferenceKey key;
  ReferenceSource source = ReferenceSource::measured;
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  std::optional<Registration> registration;  ///< active while it was taken
  std::vector<Mode> aberration;              ///< shown while it was taken, RMS-normalised waves
  std::vector<Mode> introduced;  ///< part of `aberration` that was introduced, no correction
  std::vector<Vec2> positions_px;
  std::vector<Vec2> standard_error_px;
  std::shared_ptr<const ReferenceImage> picture;  ///< null: too few frames, or discarded
  std::vector<BeamReference> beams;               ///< of the further sources, if any were taken
  std::shared_ptr<const nlohmann::json> origin;   ///< see ReferenceBench; null: none recorded
  std::string sha256;                             ///< of the reference's file; empty: not stored
};

/// RMS wavefront error of these modes in waves: the root of the sum of squared coefficients.
double rms_waves(const std::vector<Mode>& modes);

}  // namespace ovws
