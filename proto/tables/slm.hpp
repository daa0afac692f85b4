/// Field tables of the spatial light modulator: look-up table, flatness, settle time, read-back.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/phase_response.hpp"
#include "core/optics/settle_time.hpp"
#include "core/port/display.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {

template <>
inline constexpr auto kTable<DisplayInfo> =
    Fields{"DisplayInfo",
           field<&DisplayInfo::output>("name of the output, e.g. HDMI-1"),
           field<&DisplayInfo::driver>("x11, wayland or KMSDRM"),
           field<&DisplayInfo::width>("width, pixels", Bounds::at_least(1)),
           field<&DisplayInfo::height>("height, pixels", Bounds::at_least(1)),
           field<&DisplayInfo::refresh_hz>("refresh rate, Hz", Bounds::at_least(0))};

/// A measured look-up table and the phase response that it was made from.
struct LutMeasured {
  std::int64_t t_taken_ns = 0;
  int frames = 0;
  PhaseResponse response;
  PhaseTable table;
  std::string sha256;  ///< empty: not stored on disk
  JsonOf<Origin> origin;
};
template <>
inline constexpr auto kTable<LutMeasured> = Fields{
    "LutMeasured",
    field<&LutMeasured::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &LutMeasured::t_taken_ns),
    field<&LutMeasured::sha256>(kSha256Meaning).or_null(),
    field<&LutMeasured::frames>("number of frames averaged for each image", Bounds::at_least(1)),
    computed("levels", [](auto& m) { return m.response.levels; },
             "number of measured grey levels, each measured twice", {2, 256}),
    computed(
        "phase_rad", [](auto& m) { return m.response.phase_rad; },
        "smoothed phase of each grey level relative to grey level 0, rising or falling throughout, "
        "radians; "
        "its sign is that with which a blazed grating sends its light to the camera"),
    computed(
        "standard_error_rad", [](auto& m) { return m.response.standard_error_rad; },
        "standard error of each phase relative to grey level 0, radians", Bounds::at_least(0)),
    computed(
        "noise_rad", [](auto& m) { return m.response.noise_rad; },
        "RMS noise of the measured phase of one grey level, radians", Bounds::at_least(0)),
    computed(
        "residual_rad", [](auto& m) { return m.response.residual_rad; },
        "RMS difference between the measured phases and phase_rad, radians", Bounds::at_least(0)),
    computed(
        "depth_rad", [](auto& m) { return m.response.depth_rad(); },
        "absolute phase of grey level 255, radians", Bounds::at_least(0)),
    computed(
        "falls", [](auto& m) { return m.response.falls(); },
        "whether the phase falls with the grey level; the table then falls too"),
    computed(
        "reaches_2pi", [](auto& m) { return m.table.reason.empty(); },
        "whether every phase can be shown"),
    computed("steps_out_of_reach", [](auto& m) { return m.table.steps_out_of_reach; },
             "number of the table's 256 phase steps that lie more than half a step beyond the "
             "depth; they are shown by grey level 255 or 0, whichever is nearer",
             {0, 255}),
    computed(
        "reason", [](auto& m) { return m.table.reason; },
        "how much phase is missing to 2 pi, and how such phases are shown; null: 2 pi is reached")
        .or_null(),
    field<&LutMeasured::origin>("bench and settings of the measurement")};

/// Result of `lut.get`, `lut.clear` and the `lut.run` job.
struct LutReport {
  PhaseLut in_use = linear_lut();
  std::optional<std::string> path;  ///< file named in the configuration
  std::optional<LutMeasured> measured;
};
template <>
inline constexpr auto kTable<LutReport> = Fields{
    "LutReport",
    computed(
        "source",
        [](auto& lut) { return lut.measured ? "measured"
                               : lut.path   ? "file"
                                            : "linear"; },
        "source of the active table")
        .among(texts<"linear", "file", "measured">),
    field<&LutReport::path>("slm.lut of the configuration"),
    field("grey_levels", &LutReport::in_use,
          "the active table: entry k is the grey level for the phase 2 pi k/256", {0, 255})
        .sized(256, 256),
    computed(
        "measured", [](auto& lut) { return lut.measured.has_value(); },
        "whether a measured table is active; if not, all values of the measurement are null"),
    inlined(&LutReport::measured)};

struct FlatnessMode {
  int j = 0;
  double waves = 0.0, standard_error_waves = 0.0;
};
template <>
inline constexpr auto kTable<FlatnessMode> =
    Fields{"FlatnessMode", field<&FlatnessMode::j>(kModeIndexMeaning, Bounds::at_least(3)),
           field<&FlatnessMode::waves>("coefficient, RMS-normalised waves"),
           field<&FlatnessMode::standard_error_waves>(
               "standard error, from the residual of the fit, waves", Bounds::at_least(0))};

struct FlatnessMeasured {
  std::int64_t t_taken_ns = 0;
  int frames = 0;
  int iterations = 0;
  double pupil_diameter_px = 0.0;
  std::vector<FlatnessMode> modes;
  double residual_rms_waves = 0.0;
  std::string sha256;  ///< empty: not stored on disk
  JsonOf<Origin> origin;
};
template <>
inline constexpr auto kTable<FlatnessMeasured> = Fields{
    "FlatnessMeasured",
    field<&FlatnessMeasured::t_taken_ns>(kTimeMeaning),
    time_text("t_taken", &FlatnessMeasured::t_taken_ns),
    field<&FlatnessMeasured::sha256>(kSha256Meaning).or_null(),
    field<&FlatnessMeasured::frames>("number of frames averaged at each position of the aperture",
                                     Bounds::at_least(1)),
    field<&FlatnessMeasured::iterations>("number of scans of the pupil until convergence",
                                         Bounds::at_least(1)),
    field<&FlatnessMeasured::pupil_diameter_px>(
        "diameter of the circle over which the modes are normalised, SLM pixels"),
    field<&FlatnessMeasured::modes>("modes of the measured error, which the hologram subtracts"),
    computed(
        "rms_waves",
        [](auto& m) {
          double squares = 0.0;
          for (const FlatnessMode& mode : m.modes) squares += mode.waves * mode.waves;
          return std::sqrt(squares);
        },
        "root sum square of the modes, waves", Bounds::at_least(0)),
    field<&FlatnessMeasured::residual_rms_waves>(
        "change of the modes in the last scan, root sum square, waves", Bounds::at_least(0)),
    field<&FlatnessMeasured::origin>("bench and settings of the measurement")};

/// Result of `flatness.get`, `flatness.clear` and the `flatness.run` job.
struct FlatnessReport {
  std::optional<std::string> path;  ///< file named in the configuration
  std::optional<FlatnessMeasured> measured;
};
template <>
inline constexpr auto kTable<FlatnessReport> = Fields{
    "FlatnessReport",
    field<&FlatnessReport::path>("slm.flatness of the configuration, which is applied, too"),
    computed(
        "measured", [](auto& flatness) { return flatness.measured.has_value(); },
        "whether a measured flatness is active; if not, all values of the measurement are null"),
    inlined(&FlatnessReport::measured)};

/// Result of the `slm.settle` job.
struct SettleReport {
  SettleTime time;
  int repetitions = 0;
  double configured_ms = 0.0;
};
/// Why slm.settle_ms may be too short; empty: it is long enough.
std::string settle_reason(const SettleReport& report);

template <>
inline constexpr auto kTable<SettleTime> = Fields{
    "SettleTime",
    field<&SettleTime::p50_ms>("median settle time, milliseconds"),
    field<&SettleTime::mad_ms>("median absolute deviation from the median, milliseconds"),
    field<&SettleTime::max_ms>("longest time that is not an outlier, milliseconds"),
    field<&SettleTime::worst_ms>("longest time of all, milliseconds"),
    field<&SettleTime::outliers>("number of changes that took unusually long"),
    field<&SettleTime::least_ms>("lower bound of the settle time, milliseconds"),
    field<&SettleTime::resolution_ms>(
        "time resolution of one change, given by the frame rate, milliseconds"),
    field<&SettleTime::margin_ms>("safety margin in the proposal, milliseconds"),
    field("proposed_settle_ms", &SettleTime::proposed_ms, "proposed slm.settle_ms, milliseconds")};
template <>
inline constexpr auto kTable<SettleReport> = Fields{
    "SettleReport",
    field<&SettleReport::repetitions>("number of image changes"),
    inlined(&SettleReport::time),
    field("configured_settle_ms", &SettleReport::configured_ms,
          "configured slm.settle_ms, milliseconds"),
    computed(
        "long_enough", [](auto& report) { return report.configured_ms >= report.time.max_ms; },
        "whether the configured time is at least max_ms"),
    computed("reason", settle_reason,
             "why the configured time may be too short; null: it is long enough")
        .or_null()};

/// Result of `slm.verify`.
struct VerifyReport {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0, crc32_shown = 0;
  int differing_pixels = 0;
};
template <>
inline constexpr auto kTable<VerifyReport> = Fields{
    "VerifyReport",
    field<&VerifyReport::hologram_id>("number of the hologram presented last", Bounds::at_least(1)),
    field<&VerifyReport::crc32>("CRC-32 (zlib) of the hologram's grey levels, row by row"),
    field<&VerifyReport::crc32_shown>("CRC-32 of the output's pixels (blue channel)"),
    computed(
        "equal", [](auto& report) { return report.differing_pixels == 0; },
        "whether every pixel is grey and has the presented level"),
    field<&VerifyReport::differing_pixels>("number of pixels that differ", Bounds::at_least(0))};

/// Result of `slm.show`.
struct ShowReport {
  HologramKind pattern = HologramKind::sensor;
  std::uint64_t hologram_id = 0;
};
template <>
inline constexpr auto kTable<ShowReport> =
    Fields{"ShowReport", field<&ShowReport::pattern>("pattern that is shown"),
           field<&ShowReport::hologram_id>(kHologramIdMeaning)};

}  // namespace ovws
