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
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// Result of lut.run: the SLM's phase response, and the LUT that corrects it.
struct MeasuredLut {
  std::int64_t t_taken_ns = 0;
  int frames = 0;  ///< number of frames averaged for each hologram
  PhaseResponse response;
  PhaseTable table;       ///< the LUT that makes the response linear
  nlohmann::json origin;  ///< bench of the measurement; see ReferenceBench
  std::string sha256;     ///< SHA-256 of the stored file; empty: not stored
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
  double residual_rms_waves = 0.0;   ///< RMS change of the modes in the last scan
  nlohmann::json configured_sha256;  ///< SHA-256 of the configured flatness map; null: no map
  nlohmann::json origin;             ///< bench of the measurement; as in MeasuredLut
  std::string sha256;
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

/// Measured LUT as a Kind of Kept (the store). A LUT can be used with an SLM of the same size and
/// pixel pitch at the same wavelength.
struct LutKind {
  using Item = MeasuredLut;
  static constexpr const char *kKind = "lut", *kEvent = "slm", *kTitle = "LUT",
                              *kMethod = "lut.run";
  Config config;

  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& lut) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& lut) const;
};

/// Measured flatness as a Kind of Kept (the store). A flatness can be used with the same SLM, the
/// same optics and the same configured flatness map, to which it is added.
struct FlatnessKind {
  using Item = MeasuredFlatness;
  static constexpr const char *kKind = "flatness", *kEvent = "slm", *kTitle = kKind,
                              *kMethod = "flatness.run";
  Config config;
  nlohmann::json configured_sha256;  ///< SHA-256 of the slm.flatness map; null: no map

  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& flatness) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& flatness) const;
};

}  // namespace ovws
