/// Field tables of the methods' params.
#pragma once

#include <optional>
#include <vector>

#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/refine.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

using CameraSet = Partial<CameraSettings>;
using SensorSet = Partial<SensorSettings>;
using RefineSet = Partial<RefineSetup>;

/// Params of a method that takes none.
struct Nothing {};
template <>
struct Table<Nothing> {
  static constexpr const char* kName = "Nothing";
  static constexpr auto kFields = Fields{};
};

/// Params of `aberration.set` and `correction.set`. Decoding converts to RMS normalisation, keeps
/// the order and refuses duplicate modes.
struct ModesSet {
  std::vector<Mode> modes;
  static Result<ModesSet> decode(const Json& params);
};
template <>
struct Wire<ModesSet> {
  static Json to_json(const ModesSet& set);
  static Json schema(SchemaParts&, const FieldInfo&);
};

struct ReferenceTake {
  int frames = 100;
  bool allow_aberration = false;
};
template <>
struct Table<ReferenceTake> {
  static constexpr const char* kName = "ReferenceTake";
  static constexpr auto kFields =
      Fields{field("frames", &ReferenceTake::frames, "number of frames to average",
                   limits::kReferenceFrames),
             field("allow_aberration", &ReferenceTake::allow_aberration,
                   "true: accept an introduced aberration, which then is part of the reference "
                   "and not of the coefficients")};
};

/// Sources of a reference that `reference.set` accepts.
enum class ReferenceOrigin { model };
template <>
struct Names<ReferenceOrigin> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"model"};
    return names;
  }
};
struct ReferenceSet {
  ReferenceOrigin source = ReferenceOrigin::model;
};
template <>
struct Table<ReferenceSet> {
  static constexpr const char* kName = "ReferenceSet";
  static constexpr auto kFields = Fields{
      field("source", &ReferenceSet::source, "source of the reference positions").mandatory()};
};

struct RegistrationRun {
  int frames = 5;
};
template <>
struct Table<RegistrationRun> {
  static constexpr const char* kName = "RegistrationRun";
  static constexpr auto kFields =
      Fields{field("frames", &RegistrationRun::frames, "number of frames to average for each image",
                   limits::kPictureFrames)};
};

struct FlatnessRun {
  int frames = 5;
};
template <>
struct Table<FlatnessRun> {
  static constexpr const char* kName = "FlatnessRun";
  static constexpr auto kFields =
      Fields{field("frames", &FlatnessRun::frames,
                   "number of settled frames to average at each position of the aperture",
                   limits::kPictureFrames)};
};

struct LutRun {
  int levels = 33;
  int frames = 3;
};
template <>
struct Table<LutRun> {
  static constexpr const char* kName = "LutRun";
  static constexpr auto kFields =
      Fields{field("levels", &LutRun::levels,
                   "number of grey levels from 0 to 255 to measure, each twice; more are added "
                   "where the phase changes by more than 1/24 of a turn from one to the next",
                   limits::kGreyLevels),
             field("frames", &LutRun::frames, "number of frames to average for each image",
                   limits::kPictureFrames)};
};

struct SettleRun {
  int repetitions = 20;
  double watch_ms = 200.0;
};
template <>
struct Table<SettleRun> {
  static constexpr const char* kName = "SettleRun";
  static constexpr auto kFields =
      Fields{field("repetitions", &SettleRun::repetitions, "number of image changes",
                   limits::kSettleRepetitions),
             field("watch_ms", &SettleRun::watch_ms,
                   "time to watch frames after each change, milliseconds", limits::kWatchMs)};
};

struct CalibrationRun {
  std::optional<double> amplitude_waves;  ///< none: chosen by the tracker
  int frames = 20;
  std::vector<int> modes_j;  ///< empty: all that the lattice determines
};
template <>
struct Table<CalibrationRun> {
  static constexpr const char* kName = "CalibrationRun";
  static constexpr auto kFields =
      Fields{field("amplitude_waves", &CalibrationRun::amplitude_waves,
                   "poke amplitude, RMS-normalised waves; null: 0.03 with the tracker fit, which "
                   "measures every pixel, and 0.15 with trackers of positions",
                   limits::kPokeWaves),
             field("frames", &CalibrationRun::frames,
                   "number of settled frames to average for each poke", limits::kPokeFrames),
             field("modes", &CalibrationRun::modes_j,
                   "OSA/ANSI indices of the modes to measure and reconstruct; default: every "
                   "mode that the lattice determines",
                   {1, kMaxZernikeIndex})
                 .sized(1, kMaxZernikeIndex)
                 .unlike()};
};

/// Patterns that `slm.show` accepts: all but `test`, which is reserved for jobs.
struct ShowablePattern {
  HologramKind kind = HologramKind::sensor;
};
template <>
struct Wire<ShowablePattern> {
  static Json to_json(const ShowablePattern& pattern) { return pattern_name(pattern.kind); }
  static void decode(ObjectReader& reader, const FieldInfo& field, ShowablePattern& out) {
    int value = int(out.kind);
    reader.choice(field.key, value, showable_pattern_names());
    out.kind = HologramKind(value);
  }
  static Json schema(SchemaParts&, const FieldInfo&) {
    return {{"type", "string"}, {"enum", showable_pattern_names()}};
  }
};
struct SlmShow {
  ShowablePattern pattern;
};
template <>
struct Table<SlmShow> {
  static constexpr const char* kName = "SlmShow";
  static constexpr auto kFields = Fields{
      field("pattern", &SlmShow::pattern,
            "sensor: the wavefront sensor; grating: base grating and correction only, for using "
            "the corrected beam; flat: flatness map only; identify: a test image that shows which "
            "screen is the SLM and how it is oriented")
          .mandatory()};
};

struct LoopOpen {
  bool keep = true;
};
template <>
struct Table<LoopOpen> {
  static constexpr const char* kName = "LoopOpen";
  static constexpr auto kFields =
      Fields{field("keep", &LoopOpen::keep, "true: keep the correction; false: clear it")};
};

struct ExperimentCell {
  int cell = 0;
};
template <>
struct Table<ExperimentCell> {
  static constexpr const char* kName = "ExperimentCell";
  static constexpr auto kFields =
      Fields{field("cell", &ExperimentCell::cell, "number of the cell, from 0", limits::kSweepCell)
                 .mandatory()};
};

}  // namespace ovws
