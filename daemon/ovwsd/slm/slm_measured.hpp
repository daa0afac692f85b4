/// What the instrument measured of its own SLM, and the hologram's ingredients that follow.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/phase_response.hpp"

namespace ovws {

/// What lut.run measured.
struct MeasuredLut {
  std::int64_t t_taken_ns = 0;
  int frames = 0;  ///< of each picture
  PhaseResponse response;
  PhaseTable table;       ///< that makes it linear
  nlohmann::json origin;  ///< see ReferenceBench: what it was measured with
  std::string sha256;     ///< of the file that keeps it; empty: none does
};

/// What flatness.run measured: the error, of which the hologram shows the opposite.
struct MeasuredFlatness {
  std::int64_t t_taken_ns = 0;
  int frames = 0;                            ///< of each place
  int iterations = 0;                        ///< scans until nothing changed
  double pupil_diameter_px = 0.0;            ///< of the circle that the modes are of
  std::vector<Mode> modes;                   ///< j >= 3, RMS-normalised waves
  std::vector<double> standard_error_waves;  ///< of each of them
  double residual_rms_waves = 0.0;           ///< what the last scan changed
  nlohmann::json configured_sha256;          ///< of the file's map that it is added to; null: none
  nlohmann::json origin;                     ///< as of MeasuredLut
  std::string sha256;
};

/// Immutable. What is null was not measured, and is as configured.
struct SlmInForce {
  std::shared_ptr<const MeasuredLut> lut;
  std::shared_ptr<const MeasuredFlatness> flatness;
  HologramConfig hologram;  ///< its sensor means nothing
  nlohmann::json identity;  ///< geometry and checksums: pictures of another one are other pictures
};

/// Of a map as in slm_identity; null: there is none.
nlohmann::json flatness_sha256(const HologramConfig& hologram);

/// An SlmIdentity; a checksum is null where there is neither a file nor a measurement.
nlohmann::json slm_identity(const HologramConfig& hologram, bool has_lut);

/// `configured`: with the files of the configuration. A measured LUT takes the place of a file's; a
/// measured flatness is added to a file's, since it was measured with that in force.
std::shared_ptr<const SlmInForce> slm_in_force(const Config& config,
                                               const HologramConfig& configured,
                                               std::shared_ptr<const MeasuredLut> lut,
                                               std::shared_ptr<const MeasuredFlatness> flatness);

}  // namespace ovws
