/// Field tables of the closed loop.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/control/loop_model.hpp"
#include "core/control/loop_settings.hpp"
#include "core/control/step_times.hpp"
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
inline constexpr auto kTable<ModeOffset> = Fields{
    "ModeOffset", field<&ModeOffset::j>(kModeIndexMeaning, {1, kMaxZernikeIndex}).mandatory(),
    field<&ModeOffset::waves>("residual to hold in this mode, RMS-normalised waves",
                              limits::kModeWaves)
        .mandatory()};

template <>
inline constexpr NamesOf kNames<LawName> = texts<"integrator", "optimised", "predictor">;

template <>
inline constexpr auto kTable<LoopSettings> = Fields{
    "LoopSettings",
    field<&LoopSettings::law>(
        "control law: integrator, with gain, leak and gains; optimised, an integrator with the "
        "best gain of each mode; predictor, which corrects what is expected. The last two need "
        "loop.identify"),
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
    field<&LoopSettings::offsets>("residuals to hold, instead of 0").sized(0, kMaxZernikeIndex),
    field<&LoopSettings::limit_waves>("limit of each mode's correction, RMS-normalised waves",
                                      limits::kLoopLimitWaves),
    field<&LoopSettings::patience_s>(
        "time after which the loop opens by itself without a usable frame, with a mode at its "
        "limit, or with a growing residual, seconds",
        limits::kLoopPatienceS)};

template <>
inline constexpr auto kTable<StepTimes> =
    Fields{"StepTimes",
           field<&StepTimes::settle_ms>("until the liquid crystal has settled, ms"),
           field<&StepTimes::wait_ms>("until the last usable frame begins, or, if it shows an "
                                      "older hologram, until it is known, ms"),
           field<&StepTimes::exposure_ms>("exposure of that frame, ms"),
           field<&StepTimes::compute_ms>("transfer and measurement of the frame, ms"),
           field<&StepTimes::render_ms>("computation of the new correction and its hologram, ms"),
           field<&StepTimes::refresh_ms>(
               "wait for the display's next refresh, before and after the decision, ms"),
           field<&StepTimes::present_ms>("until the display has accepted the hologram, ms")};

template <>
inline constexpr auto kTable<StepSummary> = Fields{
    "StepSummary",
    field<&StepSummary::steps>("number of the last steps that are summarised"),
    field<&StepSummary::p50_ms>("median time from one hologram to the next, ms"),
    field<&StepSummary::p99_ms>("99 % of the steps take less, ms"),
    field<&StepSummary::delay_ms>(
        "mean time from the middle of a frame's exposure to the middle of the time in which the "
        "correction computed from it is shown, ms"),
    field<&StepSummary::newest_share>(
        "share of the steps that used a frame of the newest hologram; the others used an earlier "
        "frame, and the newest one serves the next step",
        {0, 1}),
    field<&StepSummary::mean>("where the time goes, mean of the steps")};

/// Result of `loop.close`, `loop.open` and `loop.get`.
struct LoopReport {
  bool closed = false;
  bool paused = false;    ///< the closed loop holds its correction
  LoopSettings settings;  ///< of the closed loop, or of the last time it was closed
  std::int64_t steps = 0;
  StepSummary step;
  std::optional<double> residual_rms_waves;
  double correction_rms_waves = 0.0;
  /// Value of opened_because after loop.open, by which clients know that the loop was opened on
  /// request.
  static constexpr const char* kOpenedOnRequest = "loop.open was called";
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
    field<&LoopReport::paused>("whether the closed loop holds its correction (loop.pause)"),
    inlined(&LoopReport::settings),
    field<&LoopReport::steps>("number of steps since the loop was last closed",
                              Bounds::at_least(0)),
    field<&LoopReport::step>("duration of the last steps"),
    field<&LoopReport::residual_rms_waves>("residual before the last step, less the offsets: root "
                                           "sum square over the corrected modes, "
                                           "waves",
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

template <>
inline constexpr auto kTable<LoopTiming> = Fields{
    "LoopTiming",
    field<&LoopTiming::step_s>("step of the loop for which the forecasts are, seconds",
                               Bounds::at_least(0)),
    field<&LoopTiming::delay_s>("delay of the correction for which the forecasts are: from the "
                                "middle of a frame's exposure to the middle of the time in which "
                                "the correction computed from it is shown, seconds",
                                Bounds::at_least(0))};

template <>
inline constexpr auto kTable<LoopForecast> = Fields{
    "LoopForecast",
    field<&LoopForecast::residual_waves>("expected RMS residual of the mode, noise that the loop "
                                         "passes on included, waves",
                                         Bounds::at_least(0)),
    field<&LoopForecast::gain_margin>(
        "least error of the correction's size that can make the loop unstable: 0.5 means half or "
        "one and a half of what is computed; null: the law corrects nothing",
        Bounds::at_least(0))
        .or_null()};

template <>
inline constexpr auto kTable<Oscillator> = Fields{
    "Oscillator", field<&Oscillator::hz>("natural frequency, Hz", Bounds::at_least(0)),
    field<&Oscillator::damping>("damping ratio; 1: motion without a preferred frequency", {0, 1}),
    field<&Oscillator::rms_waves>("RMS of this part, waves", Bounds::at_least(0))};

template <>
inline constexpr auto kTable<Disturbance> =
    Fields{"Disturbance",
           computed(
               "rms_waves", [](auto& of) { return of.rms_waves(); },
               "RMS of the disturbance without noise, waves", Bounds::at_least(0)),
           field<&Disturbance::noise_waves>(
               "RMS noise of one frame that the predictor assumes, waves", Bounds::at_least(0))
               .mandatory(),
           field<&Disturbance::parts>(
               "damped oscillators of which the disturbance is the sum, the strongest first")
               .sized(0, Disturbance::kMaxParts)
               .mandatory()};

template <>
inline constexpr auto kTable<ModeModel> =
    Fields{"ModeModel",
           field<&ModeModel::j>(kModeIndexMeaning).mandatory(),
           inlined(&ModeModel::disturbance),
           field<&ModeModel::best_gain>("best gain of an integrator", {0, 1}).mandatory(),
           field<&ModeModel::integrator>("forecast for the integrator with the last loop's gain"),
           field<&ModeModel::optimised>("forecast for the integrator with best_gain"),
           field<&ModeModel::predictor>("forecast for the predictor")};

template <>
inline constexpr auto kTable<LoopModel> =
    Fields{"LoopModel",
           field<&LoopModel::t_taken_ns>("when it was identified, UNIX epoch UTC, nanoseconds"),
           field<&LoopModel::seconds>("length of the series, seconds", Bounds::at_least(0)),
           inlined(&LoopModel::timing),
           field<&LoopModel::measured_steps>(
               "number of steps of which step_s and delay_s are the means; 0: an estimate from the "
               "settings, because the loop has not made 50 steps since it was last closed",
               Bounds::at_least(0)),
           field<&LoopModel::modes>("the identified modes").mandatory()};

/// Result of `loop.model`.
struct KnownLoopModel {
  std::optional<LoopModel> model;  ///< none: loop.identify was not run
};
template <>
inline constexpr auto kTable<KnownLoopModel> = Fields{
    "KnownLoopModel", field<&KnownLoopModel::model>("what was identified last; null: nothing yet")};

}  // namespace ovws
