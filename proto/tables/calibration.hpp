/// Field tables of calibrations.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {

template <>
inline constexpr NamesOf kNames<Disagreement> =
    texts<"none", "sign", "axes", "scale", "rotation", "parity", "order", "single_modes", "unlike">;

template <>
inline constexpr NamesOf kNames<MatrixSource> = texts<"run", "set">;

struct CalibratedMode {
  int j = 0;
  double amplitude_waves = 0.0;
  double signal_px_per_wave = 0.0, standard_error_px_per_wave = 0.0;
  std::optional<double> factor, factor_standard_error,
      correlation;  ///< none: the model has no such mode
};
template <>
inline constexpr auto kTable<CalibratedMode> = Fields{
    "CalibratedMode",
    field<&CalibratedMode::j>(kModeIndexMeaning),
    field<&CalibratedMode::amplitude_waves>(
        "amplitude of its pokes, RMS-normalised waves; a half or a quarter of the requested one if "
        "the SLM cannot show that, or if it lost spots",
        Bounds::at_least(0)),
    field<&CalibratedMode::signal_px_per_wave>(
        "signal of the mode: RMS of its matrix column over the spots, x and y, camera pixels per "
        "RMS-normalised wave",
        Bounds::at_least(0)),
    field<&CalibratedMode::standard_error_px_per_wave>(
        "RMS of the column's standard errors, camera pixels per RMS-normalised wave",
        Bounds::at_least(0)),
    field<&CalibratedMode::factor>("regression factor of the measured column on the model's "
                                   "(operator slopes); null: the model has no such mode"),
    field<&CalibratedMode::factor_standard_error>("standard error of factor, from the noise"),
    field<&CalibratedMode::correlation>(
        "correlation of the measured column with the model's, -1 to 1")};

template <>
inline constexpr auto kTable<DroppedMode> =
    Fields{"DroppedMode", field<&DroppedMode::j>(kModeIndexMeaning),
           field<&DroppedMode::reason>("why it is not reconstructed")};

struct CalibrationReport {
  double amplitude_waves = 0.0;  ///< requested poke amplitude
  int frames = 0;
  std::int64_t t_taken_ns = 0;
  InteractionMatrix matrix;
  MatrixComparison comparison;
  std::vector<int> template_modes_j;
  std::string sha256;  ///< empty: not stored on disk
  JsonOf<Origin> origin;
};
std::vector<CalibratedMode> calibrated_modes(const CalibrationReport& report);
std::vector<double> singular_values_of(const CalibrationReport& report);
template <>
inline constexpr auto kTable<CalibrationReport> = Fields{
    "CalibrationReport",
    field<&CalibrationReport::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &CalibrationReport::t_taken_ns),
    computed(
        "source", [](auto& c) { return c.matrix.source; },
        "run: measured by calibration.run; set: given by a client with calibration.set"),
    field<&CalibrationReport::sha256>(kSha256Meaning).or_null(),
    field<&CalibrationReport::amplitude_waves>("requested poke amplitude, RMS-normalised waves"),
    field<&CalibrationReport::frames>("number of frames averaged for each poke",
                                      Bounds::at_least(2)),
    computed(
        "subapertures", [](auto& c) { return c.matrix.spots(); }, "number of subapertures",
        Bounds::at_least(1)),
    computed(
        "lost_spots", [](auto& c) { return c.matrix.lost_spots; },
        "numbers of the lost spots: their rows of the matrix are 0, and modes are reconstructed "
        "without them",
        Bounds::at_least(0)),
    computed("modes", calibrated_modes, "measured modes, one per column of the matrix"),
    field<&CalibrationReport::template_modes_j>(
        "modes for which the derivative of every pixel was measured, tracker fit; empty: none",
        {1, kMaxZernikeIndex}),
    computed(
        "dropped", [](auto& c) { return c.matrix.dropped; },
        "requested modes that are not reconstructed"),
    computed("singular_values_px_per_wave", singular_values_of,
             "singular values of the matrix, largest first, camera pixels per RMS-normalised wave",
             Bounds::at_least(0)),
    computed(
        "condition_number",
        [](auto& c) {
          const std::vector<double> values = singular_values_of(c);
          return values.front() / values.back();
        },
        "condition number of the matrix: the largest singular value over the smallest",
        Bounds::at_least(1)),
    computed(
        "drift_px", [](auto& c) { return c.matrix.drift_px; },
        "drift of the unpoked spots from the start to the end of the calibration, RMS over spots "
        "and both axes, camera pixels; 0 if a client gave the matrix",
        Bounds::at_least(0)),
    computed(
        "drift_noise_px", [](auto& c) { return c.matrix.drift_noise_px; },
        "drift_px that is expected from the standard errors alone, camera pixels",
        Bounds::at_least(0)),
    computed(
        "disagreement", [](auto& c) { return c.comparison.disagreement; },
        "how the matrix differs from the model's: sign (of all displacements, of x, of y or of "
        "single modes), axes (x and y exchanged), scale, rotation, parity (modes inverted, as by a "
        "camera that sees the lattice mirrored or from the other side), order (of the modes), "
        "single_modes (other factors), unlike (none of these); none: they agree"),
    computed(
        "disagreement_reason", [](auto& c) { return c.comparison.words; },
        "explanation of the disagreement, and what to do; null: they agree")
        .or_null(),
    field<&CalibrationReport::origin>("bench and settings of the measurement; aberration: shown "
                                      "under the pokes, minus the correction")};

/// Result of `calibration.get`, `calibration.clear` and the `calibration.run` job.
struct KnownCalibration {
  bool in_force = false;
  std::optional<CalibrationReport> calibration;
};
template <>
inline constexpr auto kTable<KnownCalibration> =
    Fields{"KnownCalibration",
           computed(
               "calibrated", [](auto& known) { return known.calibration.has_value(); },
               "whether there is a calibration for this sensor, camera, region, tracker and "
               "registration; if not, all other keys are false or null"),
           field<&KnownCalibration::in_force>(
               "whether it is active: modes are reconstructed with it (operator measured)"),
           inlined(&KnownCalibration::calibration)};

}  // namespace ovws
