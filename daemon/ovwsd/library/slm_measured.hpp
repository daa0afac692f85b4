/// Measured LUT and flatness of the SLM, with their files and the resulting hologram settings.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/phase_response.hpp"
#include "daemon/ovwsd/library/bench_key.hpp"
#include "proto/tables/map.hpp"

namespace ovws {

/// Result of lut.run: the SLM's phase response, and the LUT that corrects it.
struct MeasuredLut {
  std::int64_t t_taken_ns = 0;
  int frames = 0;  ///< number of frames averaged for each hologram
  PhaseResponse response;
  PhaseTable table;                                ///< the LUT that makes the response linear
  BenchKey key{};                                  ///< what the LUT depends on
  std::shared_ptr<const nlohmann::json> origin{};  ///< see make_origin; never null in use
};

/// Result of flatness.run or map.run: the SLM's phase error. The hologram adds the opposite of it.
struct MeasuredFlatness {
  std::int64_t t_taken_ns = 0;
  int frames = 0;                            ///< frames averaged at each place of the scan
  int iterations = 0;                        ///< number of scans
  double pupil_diameter_px = 0.0;            ///< circle on which the modes are defined
  std::vector<Mode> modes;                   ///< j >= 3, RMS-normalised waves
  std::vector<double> standard_error_waves;  ///< of each mode
  /// What the modes leave of the error: a map over the pupil's square, NaN outside; empty: nothing.
  Image<float> fine{};
  double residual_rms_waves = 0.0;                 ///< RMS change of the modes in the last scan
  BenchKey key{};                                  ///< what the flatness depends on
  std::shared_ptr<const nlohmann::json> origin{};  ///< see make_origin; never null in use
};

/// SLM data in use: measurements and hologram settings. Immutable. If a measurement is null, the
/// file of the configuration is used, if there is one.
struct ActiveSlm {
  std::shared_ptr<const MeasuredLut> lut;
  std::shared_ptr<const MeasuredFlatness> flatness;
  HologramConfig hologram;  ///< its sensor settings are not used
  /// SLM identity: geometry and checksums. Images taken with different identities cannot be
  /// compared.
  nlohmann::json identity;
};

/// SHA-256 of the hologram's flatness map, as in slm_identity; null: there is no map.
nlohmann::json flatness_sha256(const HologramConfig& hologram);

/// The SLM's identity (SlmIdentity) as JSON. A checksum is null if there is neither a file nor a
/// measurement.
nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut);

/// Combines measurements with `configured`, the hologram settings from the configuration's files. A
/// measured LUT replaces the LUT of the file. A measured flatness is added to the file's flatness
/// map, because this map was active during the measurement.
std::shared_ptr<const ActiveSlm> active_slm(const Config& config, const HologramConfig& configured,
                                            std::shared_ptr<const MeasuredLut> lut,
                                            std::shared_ptr<const MeasuredFlatness> flatness);

/// A square map for the files and for map.run.
PupilPicture picture_of(const Image<float>& map);

// Conversion to the JSON content of the files, and back. Errors (Errc::invalid) name the
// inconsistent field.
nlohmann::json lut_content(const MeasuredLut& lut);
Result<MeasuredLut> lut_from(const nlohmann::json& content);
nlohmann::json flatness_content(const MeasuredFlatness& flatness);
Result<MeasuredFlatness> flatness_from(const nlohmann::json& content);

}  // namespace ovws
