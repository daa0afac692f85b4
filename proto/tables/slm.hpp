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
struct Table<DisplayInfo> {
  static constexpr const char* kName = "DisplayInfo";
  static constexpr auto kFields = Fields{
      field("output", &DisplayInfo::output, "name of the output, e.g. HDMI-1"),
      field("driver", &DisplayInfo::driver, "x11, wayland or KMSDRM"),
      field("width", &DisplayInfo::width, "width, pixels", Bounds::at_least(1)),
      field("height", &DisplayInfo::height, "height, pixels", Bounds::at_least(1)),
      field("refresh_hz", &DisplayInfo::refresh_hz, "refresh rate, Hz", Bounds::at_least(0))};
};

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
struct Table<LutMeasured> {
  using M = LutMeasured;
  static constexpr const char* kName = "LutMeasured";
  static constexpr auto kFields = Fields{
      field("t_taken_ns", &M::t_taken_ns, kTimeMeaning),
      time_text("t_taken", &M::t_taken_ns),
      field("sha256", &M::sha256, kSha256Meaning).or_null(),
      field("frames", &M::frames, "number of frames averaged for each image", Bounds::at_least(1)),
      computed<M>("levels", [](const M& m) { return m.response.levels; },
                  "number of measured grey levels, each measured twice", {2, 256}),
      computed<M>(
          "phase_rad", [](const M& m) { return m.response.phase_rad; },
          "phase of each grey level relative to grey level 0, rising or falling throughout, "
          "radians; its sign is that with which a blazed grating sends its light to the camera"),
      computed<M>(
          "standard_error_rad", [](const M& m) { return m.response.standard_error_rad; },
          "standard error of each phase relative to grey level 0, radians", Bounds::at_least(0)),
      computed<M>(
          "noise_rad", [](const M& m) { return m.response.noise_rad; },
          "RMS error of one measured level, radians", Bounds::at_least(0)),
      computed<M>(
          "residual_rad", [](const M& m) { return m.response.residual_rad; },
          "RMS of the measured levels about phase_rad, radians", Bounds::at_least(0)),
      computed<M>(
          "depth_rad", [](const M& m) { return m.response.depth_rad(); },
          "absolute phase of grey level 255, radians", Bounds::at_least(0)),
      computed<M>(
          "falls", [](const M& m) { return m.response.falls(); },
          "whether the phase falls with the grey level; the table then falls too"),
      computed<M>(
          "reaches_2pi", [](const M& m) { return m.table.reason.empty(); },
          "whether every phase can be shown"),
      computed<M>("steps_out_of_reach", [](const M& m) { return m.table.steps_out_of_reach; },
                  "number of the table's 256 phase steps that lie more than half a step beyond the "
                  "depth; they are shown by grey level 255 or 0, whichever is nearer",
                  {0, 255}),
      computed<M>(
          "reason", [](const M& m) { return m.table.reason; },
          "how much phase is missing to 2 pi, and how such phases are shown; null: 2 pi is reached")
          .or_null(),
      field("origin", &M::origin, "bench and settings of the measurement")};
};

/// Result of `lut.get`, `lut.clear` and the `lut.run` job.
struct LutReport {
  PhaseLut in_use = linear_lut();
  std::optional<std::string> path;  ///< file named in the configuration
  std::optional<LutMeasured> measured;
};
template <>
struct Table<LutReport> {
  static constexpr const char* kName = "LutReport";
  static constexpr auto kFields = Fields{
      computed<LutReport>(
          "source",
          [](const LutReport& lut) {
            return lut.measured ? "measured" : lut.path ? "file" : "linear";
          },
          "source of the active table")
          .among([] {
            return std::vector<std::string>{"linear", "file", "measured"};
          }),
      field("path", &LutReport::path, "slm.lut of the configuration"),
      field("grey_levels", &LutReport::in_use,
            "the active table: entry k is the grey level for the phase 2 pi k/256", {0, 255})
          .sized(256, 256),
      computed<LutReport>(
          "measured", [](const LutReport& lut) { return lut.measured.has_value(); },
          "whether a measured table is active; if not, all values of the measurement are null"),
      inlined(&LutReport::measured)};
};

struct FlatnessMode {
  int j = 0;
  double waves = 0.0, standard_error_waves = 0.0;
};
template <>
struct Table<FlatnessMode> {
  static constexpr const char* kName = "FlatnessMode";
  static constexpr auto kFields =
      Fields{field("j", &FlatnessMode::j, kModeIndexMeaning, Bounds::at_least(3)),
             field("waves", &FlatnessMode::waves, "coefficient, RMS-normalised waves"),
             field("standard_error_waves", &FlatnessMode::standard_error_waves,
                   "standard error, from the residual of the fit, waves", Bounds::at_least(0))};
};

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
struct Table<FlatnessMeasured> {
  using M = FlatnessMeasured;
  static constexpr const char* kName = "FlatnessMeasured";
  static constexpr auto kFields = Fields{
      field("t_taken_ns", &M::t_taken_ns, kTimeMeaning),
      time_text("t_taken", &M::t_taken_ns),
      field("sha256", &M::sha256, kSha256Meaning).or_null(),
      field("frames", &M::frames, "number of frames averaged at each position of the aperture",
            Bounds::at_least(1)),
      field("iterations", &M::iterations, "number of scans of the pupil until convergence",
            Bounds::at_least(1)),
      field("pupil_diameter_px", &M::pupil_diameter_px,
            "diameter of the circle over which the modes are normalised, SLM pixels"),
      field("modes", &M::modes, "modes of the measured error; the hologram shows the opposite"),
      computed<M>(
          "rms_waves",
          [](const M& m) {
            double squares = 0.0;
            for (const FlatnessMode& mode : m.modes) squares += mode.waves * mode.waves;
            return std::sqrt(squares);
          },
          "root sum square of the modes, waves", Bounds::at_least(0)),
      field("residual_rms_waves", &M::residual_rms_waves,
            "change of the modes in the last scan, root sum square, waves", Bounds::at_least(0)),
      field("origin", &M::origin, "bench and settings of the measurement")};
};

/// Result of `flatness.get`, `flatness.clear` and the `flatness.run` job.
struct FlatnessReport {
  std::optional<std::string> path;  ///< file named in the configuration
  std::optional<FlatnessMeasured> measured;
};
template <>
struct Table<FlatnessReport> {
  static constexpr const char* kName = "FlatnessReport";
  static constexpr auto kFields = Fields{
      field("path", &FlatnessReport::path,
            "slm.flatness of the configuration, which is applied, too"),
      computed<FlatnessReport>(
          "measured", [](const FlatnessReport& flatness) { return flatness.measured.has_value(); },
          "whether a measured flatness is active; if not, all values of the measurement are null"),
      inlined(&FlatnessReport::measured)};
};

/// Result of the `slm.settle` job.
struct SettleReport {
  SettleTime time;
  int repetitions = 0;
  double configured_ms = 0.0;
};
/// Why slm.settle_ms may be too short; empty: it is long enough.
std::string settle_reason(const SettleReport& report);

template <>
struct Table<SettleTime> {
  static constexpr const char* kName = "SettleTime";
  static constexpr auto kFields = Fields{
      field("p50_ms", &SettleTime::p50_ms, "median settle time, milliseconds"),
      field("mad_ms", &SettleTime::mad_ms,
            "median absolute deviation from the median, milliseconds"),
      field("max_ms", &SettleTime::max_ms, "longest time that is not an outlier, milliseconds"),
      field("worst_ms", &SettleTime::worst_ms, "longest time of all, milliseconds"),
      field("outliers", &SettleTime::outliers, "number of changes that took unusually long"),
      field("least_ms", &SettleTime::least_ms, "lower bound of the settle time, milliseconds"),
      field("resolution_ms", &SettleTime::resolution_ms,
            "time resolution of one change, given by the frame rate, milliseconds"),
      field("margin_ms", &SettleTime::margin_ms, "safety margin in the proposal, milliseconds"),
      field("proposed_settle_ms", &SettleTime::proposed_ms,
            "proposed slm.settle_ms, milliseconds")};
};
template <>
struct Table<SettleReport> {
  static constexpr const char* kName = "SettleReport";
  static constexpr auto kFields = Fields{
      field("repetitions", &SettleReport::repetitions, "number of image changes"),
      inlined(&SettleReport::time),
      field("configured_settle_ms", &SettleReport::configured_ms,
            "configured slm.settle_ms, milliseconds"),
      computed<SettleReport>(
          "long_enough",
          [](const SettleReport& report) { return report.configured_ms >= report.time.max_ms; },
          "whether the configured time is at least max_ms"),
      computed<SettleReport>("reason", settle_reason,
                             "why the configured time may be too short; null: it is long enough")
          .or_null()};
};

/// Result of `slm.verify`.
struct VerifyReport {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0, crc32_shown = 0;
  int differing_pixels = 0;
};
template <>
struct Table<VerifyReport> {
  static constexpr const char* kName = "VerifyReport";
  static constexpr auto kFields =
      Fields{field("hologram_id", &VerifyReport::hologram_id,
                   "number of the hologram presented last", Bounds::at_least(1)),
             field("crc32", &VerifyReport::crc32,
                   "CRC-32 (zlib) of the hologram's grey levels, row by row"),
             field("crc32_shown", &VerifyReport::crc32_shown,
                   "CRC-32 of the output's pixels (blue channel)"),
             computed<VerifyReport>(
                 "equal", [](const VerifyReport& report) { return report.differing_pixels == 0; },
                 "whether every pixel is grey and has the presented level"),
             field("differing_pixels", &VerifyReport::differing_pixels,
                   "number of pixels that differ", Bounds::at_least(0))};
};

/// Result of `slm.show`.
struct ShowReport {
  HologramKind pattern = HologramKind::sensor;
  std::uint64_t hologram_id = 0;
};
template <>
struct Table<ShowReport> {
  static constexpr const char* kName = "ShowReport";
  static constexpr auto kFields =
      Fields{field("pattern", &ShowReport::pattern, "pattern that is shown"),
             field("hologram_id", &ShowReport::hologram_id, kHologramIdMeaning)};
};

}  // namespace ovws
