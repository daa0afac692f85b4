/// Field tables of the closed loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/control/integrator.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

template <>
struct Table<ModeGain> {
  static constexpr const char* kName = "ModeGain";
  static constexpr auto kFields =
      Fields{field("j", &ModeGain::j, kModeIndexMeaning, {1, kMaxZernikeIndex}).mandatory(),
             field("gain", &ModeGain::gain,
                   "gain of this mode instead of the common gain: fraction of the residual "
                   "that a step corrects",
                   {0.0, limits::kLoopGain.max})
                 .mandatory()};
};

template <>
struct Table<LoopSettings> {
  static constexpr const char* kName = "LoopSettings";
  static constexpr auto kFields = Fields{
      field("gain", &LoopSettings::gain,
            "integrator gain: fraction of the residual that a step corrects", limits::kLoopGain),
      field("leak", &LoopSettings::leak,
            "integrator leak: fraction of the correction that a step removes", limits::kLoopLeak),
      field("modes", &LoopSettings::modes,
            "OSA/ANSI indices of the modes to correct; omitted or null: all measured modes",
            {1, kMaxZernikeIndex})
          .sized(1, kMaxZernikeIndex)
          .unlike()
          .or_null(),
      field("gains", &LoopSettings::gains, "individual gains of modes").sized(0, kMaxZernikeIndex),
      field("limit_waves", &LoopSettings::limit_waves,
            "limit of each mode's correction, RMS-normalised waves", limits::kLoopLimitWaves),
      field("patience_s", &LoopSettings::patience_s,
            "time after which the loop opens by itself without a usable frame, with a mode at its "
            "limit, or with a growing residual, seconds",
            limits::kLoopPatienceS)};
};

/// Result of `loop.close`, `loop.open` and `loop.get`.
struct LoopReport {
  bool closed = false;
  LoopSettings settings;  ///< of the closed loop, or of the last time it was closed
  std::int64_t steps = 0;
  std::optional<double> residual_rms_waves;
  double correction_rms_waves = 0.0;
  std::string opened_because;    ///< empty: it is closed, or was never closed
  std::int64_t t_opened_ns = 0;  ///< valid only if opened_because is not empty

  std::optional<std::int64_t> opened_ns() const {
    return opened_because.empty() ? std::nullopt : std::optional(t_opened_ns);
  }
};
template <>
struct Table<LoopReport> {
  static constexpr const char* kName = "LoopReport";
  static constexpr auto kFields = Fields{
      field("closed", &LoopReport::closed, "whether the loop is closed"),
      inlined(&LoopReport::settings),
      field("steps", &LoopReport::steps, "number of steps since the loop was last closed",
            Bounds::at_least(0)),
      field("residual_rms_waves", &LoopReport::residual_rms_waves,
            "residual before the last step: root sum square over the corrected modes, waves",
            Bounds::at_least(0)),
      field("correction_rms_waves", &LoopReport::correction_rms_waves,
            "root sum square of the correction's modes, waves", Bounds::at_least(0)),
      field("opened_because", &LoopReport::opened_because,
            "why the loop was opened; null: it is closed, or was never closed")
          .or_null(),
      computed<LoopReport>(
          "t_opened_ns", [](const LoopReport& report) { return report.opened_ns(); },
          "when the loop was opened, UNIX epoch UTC, nanoseconds; null as opened_because"),
      computed<LoopReport>(
          "t_opened",
          [](const LoopReport& report) {
            return report.opened_ns() ? std::optional(utc_text(*report.opened_ns())) : std::nullopt;
          },
          kTimeTextMeaning)};
};

}  // namespace ovws
