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
#include "core/optics/zernike.hpp"
#include "core/tracking/spot.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"
#include "daemon/ovwsd/library/reference_image.hpp"
#include "proto/field.hpp"

namespace ovws {

enum class ReferenceSource {
  measured,  ///< averaged from frames
  model,     ///< computed: coefficients then contain the bench's misalignment
};
template <>
inline constexpr NamesOf kNames<ReferenceSource> = texts<"measured", "model">;

/// The part of a reference that belongs to one light source.
struct SourceReference {
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  std::vector<Mode> aberration;  ///< shown while it was taken, RMS-normalised waves
  std::vector<Mode> introduced;  ///< part of `aberration` that was introduced, no correction
  std::vector<Vec2> positions_px, standard_error_px;
};

/// The part of a further source.
struct BeamReference : SourceReference {
  std::string beam;  ///< name in the configuration
  Vec2 offset_px;    ///< as configured when it was taken
};

/// A reference, with the part of the main source.
struct Reference : SourceReference {
  BenchKey key;
  ReferenceSource source = ReferenceSource::measured;
  std::optional<Registration> registration;       ///< active while it was taken
  std::shared_ptr<const ReferenceImage> picture;  ///< null: too few frames, or discarded
  std::vector<BeamReference> beams;               ///< of the further sources, if any were taken
  std::shared_ptr<const nlohmann::json> origin;   ///< see make_origin; never null in use
  /// Whether this program is known to draw the same hologram, see drawing_obstacle.
  bool drawn_alike = true;
};

/// What it depends on. The positions of a model are computed for the bench as it is.
constexpr respect::Set respects_of(const Reference& reference) {
  return reference.source == ReferenceSource::model ? respect::kModelReference
                                                    : respect::kReference;
}

/// Converts a reference to the JSON content of its file, and back. Positions, standard errors and
/// the mean image are preserved bit for bit. Errors (Errc::invalid) name the inconsistent field.
nlohmann::json reference_content(const Reference& reference);
Result<Reference> reference_from(const nlohmann::json& content);

/// RMS wavefront error of these modes in waves: the root of the sum of squared coefficients.
double rms_waves(const std::vector<Mode>& modes);

}  // namespace ovws
