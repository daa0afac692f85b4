/// Typed encoding of what lut.* and flatness.* answer; the shapes are those of the JSON Schemas.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/phase_response.hpp"
#include "core/optics/settle_time.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

struct LutReport {
  PhaseLut in_force = linear_lut();
  std::optional<std::string> path;  ///< of the configuration's file
  struct Measured {
    std::int64_t t_taken_ns = 0;
    int frames = 0;
    PhaseResponse response;
    PhaseTable table;
    std::string sha256;  ///< of the file that keeps it; empty: it is not kept
    nlohmann::json origin;
  };
  std::optional<Measured> measured;  ///< then it is in force
};

/// `lut.get` and `.clear`, and the result of the job of `lut.run`.
nlohmann::json lut_result(const LutReport& lut);

struct FlatnessReport {
  std::optional<std::string> path;  ///< of the configuration's file
  struct Measured {
    std::int64_t t_taken_ns = 0;
    int frames = 0;
    int iterations = 0;
    double pupil_diameter_px = 0.0;
    std::vector<Mode> modes;
    std::vector<double> standard_error_waves;
    double residual_rms_waves = 0.0;
    std::string sha256;
    nlohmann::json origin;
  };
  std::optional<Measured> measured;  ///< then it is in force, on top of the file's
};

/// `flatness.get` and `.clear`, and the result of the job of `flatness.run`.
nlohmann::json flatness_result(const FlatnessReport& flatness);

/// The result of the job of `slm.settle`.
nlohmann::json settle_result(const SettleTime& time, int repetitions, double configured_ms);

/// `slm.verify`.
struct VerifyReport {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0, crc32_shown = 0;
  int differing_pixels = 0;
};
nlohmann::json verify_result(const VerifyReport& report);

}  // namespace ovws
