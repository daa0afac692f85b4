/// Field tables of the closed loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/control/loop_settings.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

template <>
inline constexpr auto kTable<ModeGain> =
    Fields{"ModeGain", field<&ModeGain::j>(kModeIndexMeaning, {1, kMaxZernikeIndex}).mandatory(),
           field<&ModeGain::gain>("gain of this mode instead of the common gain: fraction of the "
                                  "residual that a step corrects",
                                  {0.0, limits::kLoopGain.max})
               .mandatory()};

template <>
inline constexpr auto kTable<LoopSettings> = Fields{
    "LoopSettings",
    field<&LoopSettings::gain>("integrator gain: fraction of the residual that a step corrects",
                               limits::kLoopGain),
    field<&LoopSettings::leak>("integrator leak: fraction of the correction that a step removes",
                               limits::kLoopLeak),
    field<&LoopSettings::modes>(
        "OSA/ANSI indices of the modes to correct; omitted or null: all measured modes",
        {1, kMaxZernikeIndex})
        .sized(1, kMaxZernikeIndex)
        .unlike()
        .or_null(),
    field<&LoopSettings::gains>("individual gains of modes").sized(0, kMaxZernikeIndex),
    field<&LoopSettings::limit_waves>("limit of each mode's correction, RMS-normalised waves",
                                      limits::kLoopLimitWaves),
    field<&LoopSettings::patience_s>(
        "time after which the loop opens by itself without a usable frame, with a mode at its "
        "limit, or with a growing residual, seconds",
        limits::kLoopPatienceS)};

/// Result of `loop.close`, `loop.open` and `loop.get`.
struct LoopReport {
  bool closed = false;
  LoopSettings settings;  ///< of the closed loop, or of the last time it was closed
  std::int64_t steps = 0;
  std::optional<double> residual_rms_waves;
  double correction_rms_waves = 0.0;
  std::string opened_because;    ///< empty: the loop is closed, or never was
  std::int64_t t_opened_ns = 0;  ///< valid only if opened_because is not empty

  std::optional<std::int64_t> opened_ns() const {
    return opened_because.empty() ? std::nullopt : std::optional(t_opened_ns);
  }
};
template <>
inline constexpr auto kTable<LoopReport> = Fields{
    "LoopReport",
    field<&LoopReport::closed>("whether the loop is closed"),
    inlined(&LoopReport::settings),
    field<&LoopReport::steps>("number of steps since the loop was last closed",
                              Bounds::at_least(0)),
    field<&LoopReport::residual_rms_waves>(
        "residual before the last step: root sum square over the corrected modes, waves",
        Bounds::at_least(0)),
    field<&LoopReport::correction_rms_waves>("root sum square of the correction's modes, waves",
                                             Bounds::at_least(0)),
    field<&LoopReport::opened_because>(
        "why the loop was opened; null: it is closed, or was never closed")
        .or_null(),
    computed(
        "t_opened_ns", [](auto& report) { return report.opened_ns(); },
        "when the loop was opened, UNIX epoch UTC, nanoseconds; null as opened_because"),
    computed(
        "t_opened",
        [](auto& report) {
          return report.opened_ns() ? std::optional(utc_text(*report.opened_ns())) : std::nullopt;
        },
        kTimeTextMeaning)};

}  // namespace ovws
