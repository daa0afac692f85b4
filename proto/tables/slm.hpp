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
      field("width", &DisplayInfo::width, "pixels", Bounds::at_least(1)),
      field("height", &DisplayInfo::height, "pixels", Bounds::at_least(1)),
      field("refresh_hz", &DisplayInfo::refresh_hz, "images per second", Bounds::at_least(0))};
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
      field("frames", &M::frames, "averaged for each picture", Bounds::at_least(1)),
      computed<M>("levels", [](const M& m) { return m.response.levels; },
                  "grey levels that were measured, each twice", {2, 256}),
      computed<M>(
          "phase_rad", [](const M& m) { return m.response.phase_rad; },
          "phase of each grey level, 0 at grey level 0, rising or falling throughout, "
          "radians; its sign is the one with which a blazed grating brings its light to "
          "the camera"),
      computed<M>(
          "standard_error_rad", [](const M& m) { return m.response.standard_error_rad; },
          "of each of them against grey level 0, radians", Bounds::at_least(0)),
      computed<M>(
          "noise_rad", [](const M& m) { return m.response.noise_rad; },
          "RMS error of one measured level, radians", Bounds::at_least(0)),
      computed<M>(
          "residual_rad", [](const M& m) { return m.response.residual_rad; },
          "RMS of the measured levels about phase_rad, radians", Bounds::at_least(0)),
      computed<M>(
          "depth_rad", [](const M& m) { return m.response.depth_rad(); },
          "phase of grey level 255, radians, without its sign", Bounds::at_least(0)),
      computed<M>(
          "falls", [](const M& m) { return m.response.falls(); },
          "whether the phase falls with the grey level; the table then falls too"),
      computed<M>(
          "reaches_2pi", [](const M& m) { return m.table.reason.empty(); },
          "whether every phase can be shown"),
      computed<M>("steps_out_of_reach", [](const M& m) { return m.table.steps_out_of_reach; },
                  "how many of the table's 256 steps lie more than half a step beyond the depth; "
                  "they are shown by grey level 255 or 0, whichever is nearer",
                  {0, 255}),
      computed<M>(
          "reason", [](const M& m) { return m.table.reason; },
          "what is lacking of 2 pi, and what is done then; null if it is reached")
          .or_null(),
      field("origin", &M::origin, "what it was measured with")};
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
  static constexpr auto kFields =
      Fields{computed<LutReport>(
                 "source",
                 [](const LutReport& lut) {
                   return lut.measured ? "measured" : lut.path ? "file" : "linear";
                 },
                 "where the table in use comes from")
                 .among([] {
                   return std::vector<std::string>{"linear", "file", "measured"};
                 }),
             field("path", &LutReport::path, "slm.lut of the configuration"),
             field("grey_levels", &LutReport::in_use,
                   "the table in use: the k-th is shown for the phase 2 pi k/256", {0, 255})
                 .sized(256, 256),
             computed<LutReport>(
                 "measured", [](const LutReport& lut) { return lut.measured.has_value(); },
                 "whether a measured table is in use; if not, all that follows is null"),
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
             field("waves", &FlatnessMode::waves, "RMS-normalised"),
             field("standard_error_waves", &FlatnessMode::standard_error_waves,
                   "by what the modes leave of the places", Bounds::at_least(0))};
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
  static constexpr auto kFields =
      Fields{field("t_taken_ns", &M::t_taken_ns, kTimeMeaning),
             time_text("t_taken", &M::t_taken_ns),
             field("sha256", &M::sha256, kSha256Meaning).or_null(),
             field("frames", &M::frames, "averaged for each place of the spot's aperture",
                   Bounds::at_least(1)),
             field("iterations", &M::iterations, "scans of the pupil until nothing changed",
                   Bounds::at_least(1)),
             field("pupil_diameter_px", &M::pupil_diameter_px,
                   "of the circle over which the modes are normalised, SLM pixels"),
             field("modes", &M::modes, "the error that was found; the hologram shows the opposite"),
             computed<M>(
                 "rms_waves",
                 [](const M& m) {
                   double squares = 0.0;
                   for (const FlatnessMode& mode : m.modes) squares += mode.waves * mode.waves;
                   return std::sqrt(squares);
                 },
                 "root sum square of the modes, waves", Bounds::at_least(0)),
             field("residual_rms_waves", &M::residual_rms_waves,
                   "how far the last scan's modes are from those before, root sum square, waves",
                   Bounds::at_least(0)),
             field("origin", &M::origin, "what it was measured with")};
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
            "slm.flatness of the configuration, which is in use, too"),
      computed<FlatnessReport>(
          "measured", [](const FlatnessReport& flatness) { return flatness.measured.has_value(); },
          "whether a measured flatness is in use; if not, all that follows is null"),
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
  static constexpr auto kFields =
      Fields{field("p50_ms", &SettleTime::p50_ms, "median, milliseconds"),
             field("mad_ms", &SettleTime::mad_ms, "median absolute deviation from it"),
             field("max_ms", &SettleTime::max_ms, "longest that is no outlier"),
             field("worst_ms", &SettleTime::worst_ms, "longest of all"),
             field("outliers", &SettleTime::outliers, "changes that took unusually long"),
             field("least_ms", &SettleTime::least_ms, "it is no shorter"),
             field("resolution_ms", &SettleTime::resolution_ms, "of one change, by the frame rate"),
             field("margin_ms", &SettleTime::margin_ms, "added for the proposal"),
             field("proposed_settle_ms", &SettleTime::proposed_ms, "for slm.settle_ms")};
};
template <>
struct Table<SettleReport> {
  static constexpr const char* kName = "SettleReport";
  static constexpr auto kFields = Fields{
      field("repetitions", &SettleReport::repetitions, "changes of the picture"),
      inlined(&SettleReport::time),
      field("configured_settle_ms", &SettleReport::configured_ms, "slm.settle_ms"),
      computed<SettleReport>(
          "long_enough",
          [](const SettleReport& report) { return report.configured_ms >= report.time.max_ms; },
          "whether that is enough"),
      computed<SettleReport>("reason", settle_reason, "what is wrong with it; null: nothing")
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
  static constexpr auto kFields = Fields{
      field("hologram_id", &VerifyReport::hologram_id, "presented last", Bounds::at_least(1)),
      field("crc32", &VerifyReport::crc32, "CRC-32 (zlib's) of its grey levels, row by row"),
      field("crc32_shown", &VerifyReport::crc32_shown, "of the output's pixels (their blue)"),
      computed<VerifyReport>(
          "equal", [](const VerifyReport& report) { return report.differing_pixels == 0; },
          "whether every pixel is grey and of the level presented"),
      field("differing_pixels", &VerifyReport::differing_pixels, "how many are not",
            Bounds::at_least(0))};
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
      Fields{field("pattern", &ShowReport::pattern, "as set"),
             field("hologram_id", &ShowReport::hologram_id, kHologramIdMeaning)};
};

}  // namespace ovws
