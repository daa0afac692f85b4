/// Measured LUT and flatness of the SLM, their files, and the hologram settings that follow from
/// them.
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

/// Result of lut.run: the SLM's phase response.
struct MeasuredLut {
  std::int64_t t_taken_ns = 0;
  int frames = 0;  ///< averaged for each hologram
  PhaseResponse response;
  PhaseTable table;       ///< the LUT that makes the response linear
  nlohmann::json origin;  ///< what it was measured with; see ReferenceBench
  std::string sha256;     ///< of its file in the state store; empty: it is not stored
};

/// Result of flatness.run: the phase error, whose opposite is added to the hologram.
struct MeasuredFlatness {
  std::int64_t t_taken_ns = 0;
  int frames = 0;                            ///< averaged at each place of the scan
  int iterations = 0;                        ///< number of scans
  double pupil_diameter_px = 0.0;            ///< of the circle on which the modes are defined
  std::vector<Mode> modes;                   ///< j >= 3, RMS-normalised waves
  std::vector<double> standard_error_waves;  ///< of each mode
  double residual_rms_waves = 0.0;           ///< RMS change of the modes in the last scan
  nlohmann::json configured_sha256;  ///< of the map of slm.flatness that it is added to; null: none
  nlohmann::json origin;             ///< as in MeasuredLut
  std::string sha256;
};

/// The SLM data in use; immutable. A null measurement means that the configuration's file is used,
/// if there is one.
struct ActiveSlm {
  std::shared_ptr<const MeasuredLut> lut;
  std::shared_ptr<const MeasuredFlatness> flatness;
  HologramConfig hologram;  ///< its sensor settings are not used
  /// Geometry and checksums; images that were taken with another identity cannot be compared.
  nlohmann::json identity;
};

/// Checksum of the hologram's flatness map, as in slm_identity; null: there is no map.
nlohmann::json flatness_sha256(const HologramConfig& hologram);

/// The SLM's identity (SlmIdentity) as JSON. A checksum is null if there is neither a file nor a
/// measurement.
nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut);

/// Combines measurements with `configured`, the settings from the configuration's files. A measured
/// LUT replaces that of the file. A measured flatness is added to the file's flatness map, which
/// was active during the measurement.
std::shared_ptr<const ActiveSlm> active_slm(const Config& config, const HologramConfig& configured,
                                            std::shared_ptr<const MeasuredLut> lut,
                                            std::shared_ptr<const MeasuredFlatness> flatness);

/// Measured LUTs as a Kind of Kept. One can be used with an SLM of the same size and pitch at the
/// same wavelength.
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

/// Measured flatnesses as a Kind of Kept. One can be used with the same SLM and optics, and with
/// the same configured flatness map, to which it is added.
struct FlatnessKind {
  using Item = MeasuredFlatness;
  static constexpr const char *kKind = "flatness", *kEvent = "slm", *kTitle = kKind,
                              *kMethod = "flatness.run";
  Config config;
  nlohmann::json configured_sha256;  ///< of the map of slm.flatness; null: there is none

  std::string name(const Item&) const { return "slm"; }
  nlohmann::json content(const Item& flatness) const;
  Result<Item> read(const nlohmann::json& content) const;
  std::string obstacle(const Item& flatness) const;
};

}  // namespace ovws
