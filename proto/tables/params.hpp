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

/// Params of a method without params.
struct Nothing {};
template <>
inline constexpr auto kTable<Nothing> = Fields{"Nothing"};

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

/// Params of `aberration.sequence`.
struct AberrationSequence {
  std::vector<ModesSet> patterns;
};
template <>
inline constexpr auto kTable<AberrationSequence> =
    Fields{"AberrationSequence",
           field<&AberrationSequence::patterns>(
               "of each pattern the modes that it introduces, as the params of aberration.set")
               .mandatory()
               .sized(1, int(limits::kPatternSlots.max) - 1)};

struct ReferenceTake {
  int frames = 100;
  bool allow_aberration = false;
  std::string beam;
};
template <>
inline constexpr auto kTable<ReferenceTake> = Fields{
    "ReferenceTake",
    field<&ReferenceTake::frames>("number of frames to average", limits::kReferenceFrames),
    field<&ReferenceTake::allow_aberration>("true: accept an introduced aberration, which then is "
                                            "part of the reference and not of the coefficients"),
    field<&ReferenceTake::beam>("the only light source whose reference is taken, main or a name of "
                                "`beams`; empty: all, from the same frames")};

/// Sources of a reference that `reference.set` accepts.
enum class ReferenceOrigin { model };
template <>
inline constexpr NamesOf kNames<ReferenceOrigin> = texts<"model">;
struct ReferenceSet {
  ReferenceOrigin source = ReferenceOrigin::model;
};
template <>
inline constexpr auto kTable<ReferenceSet> = Fields{
    "ReferenceSet", field<&ReferenceSet::source>("source of the reference positions").mandatory()};

/// Params of `reference.give`; the positions are the request's binary frame.
struct ReferenceGive {
  int frames = 1;
};
template <>
inline constexpr auto kTable<ReferenceGive> =
    Fields{"ReferenceGive",
           field<&ReferenceGive::frames>("number of frames that the positions are the mean of",
                                         limits::kReferenceFrames)};

struct AutoExposure {
  double target = 0.7;
  std::optional<double> max_exposure_us;  ///< none: only the camera and its frame rate limit it
};
template <>
inline constexpr auto kTable<AutoExposure> = Fields{
    "AutoExposure",
    field<&AutoExposure::target>("brightness that most spots shall reach, fraction of full scale",
                                 limits::kExposureTarget),
    field<&AutoExposure::max_exposure_us>(
        "longest exposure to use, microseconds; null: what the camera allows at its frame rate",
        limits::kExposureUs)};

struct RegistrationRun {
  int frames = 5;
};
template <>
inline constexpr auto kTable<RegistrationRun> = Fields{
    "RegistrationRun", field<&RegistrationRun::frames>("number of frames to average for each image",
                                                       limits::kImageFrames)};

struct ArrayFit {
  int frames = 20;
};
template <>
inline constexpr auto kTable<ArrayFit> = Fields{
    "ArrayFit", field<&ArrayFit::frames>("number of frames to average", limits::kReferenceFrames)};

struct FlatnessRun {
  int frames = 5;
};
template <>
inline constexpr auto kTable<FlatnessRun> = Fields{
    "FlatnessRun", field<&FlatnessRun::frames>(
                       "number of settled frames to average at each position of the aperture",
                       limits::kImageFrames)};

struct FocusRun {
  int frames = 5;
};
template <>
inline constexpr auto kTable<FocusRun> =
    Fields{"FocusRun",
           field<&FocusRun::frames>("number of settled frames to average", limits::kImageFrames)};

struct MapRun {
  int patterns = 6;
  int frames = 2;
  int cells = 100;
  bool apply = false;
};
template <>
inline constexpr auto kTable<MapRun> = Fields{
    "MapRun", field<&MapRun::patterns>("number of patterns to show", limits::kMapPatterns),
    field<&MapRun::frames>("number of settled frames to average for each image; each pattern "
                           "has two, which are compared",
                           limits::kImageFrames),
    field<&MapRun::cells>("cells of the map over the pupil's diameter; the camera's region "
                          "must have as many lambda/D",
                          limits::kMapCells),
    field<&MapRun::apply>("whether to use the map as the flatness of the SLM")};

struct LutRun {
  int levels = 33;
  int frames = 3;
};
template <>
inline constexpr auto kTable<LutRun> = Fields{
    "LutRun",
    field<&LutRun::levels>(
        "number of grey levels from 0 to 255 to measure, each twice; more are added where the "
        "phase changes by more than 1/24 of a turn from one to the next",
        limits::kGreyLevels),
    field<&LutRun::frames>("number of frames to average for each image", limits::kImageFrames)};

struct SettleRun {
  int repetitions = 20;
  double watch_ms = 200.0;
};
template <>
inline constexpr auto kTable<SettleRun> =
    Fields{"SettleRun",
           field<&SettleRun::repetitions>("number of image changes", limits::kSettleRepetitions),
           field<&SettleRun::watch_ms>("time to watch frames after each change, milliseconds",
                                       limits::kWatchMs)};

struct CalibrationRun {
  std::optional<double> amplitude_waves;  ///< poke amplitude; none: depends on the tracker
  int frames = 20;
  std::vector<int> modes_j;  ///< modes to poke; empty: all that the lattice determines
};
template <>
inline constexpr auto kTable<CalibrationRun> =
    Fields{"CalibrationRun",
           field<&CalibrationRun::amplitude_waves>(
               "poke amplitude, RMS-normalised waves; null: 0.03 with the tracker fit, which "
               "measures every pixel, and 0.15 with trackers of positions",
               limits::kPokeWaves),
           field<&CalibrationRun::frames>("number of settled frames to average for each poke",
                                          limits::kPokeFrames),
           field("modes", &CalibrationRun::modes_j,
                 "OSA/ANSI indices of the modes to measure and reconstruct; default: every mode "
                 "that the lattice determines",
                 {1, kMaxZernikeIndex})
               .sized(1, kMaxZernikeIndex)
               .unlike()};

/// Params of `calibration.set`; the matrix and its standard errors are the request's binary frame.
struct CalibrationSet {
  std::vector<int> shape;  ///< 2, 2 x subapertures, modes
  std::vector<int> modes_j;
  double amplitude_waves = 0.0;
  int frames = 0;
};
template <>
inline constexpr auto kTable<CalibrationSet> = Fields{
    "CalibrationSet",
    field<&CalibrationSet::shape>("shape of the binary frame: [2, 2 x subapertures, modes]",
                                  limits::kMatrixRows)
        .sized(3, 3)
        .mandatory(),
    field("modes", &CalibrationSet::modes_j, "OSA/ANSI indices of the columns",
          {1, kMaxZernikeIndex})
        .sized(1, kMaxZernikeIndex)
        .unlike()
        .mandatory(),
    field<&CalibrationSet::amplitude_waves>("amplitude of the pokes, RMS-normalised waves",
                                            limits::kGivenPokeWaves)
        .mandatory(),
    field<&CalibrationSet::frames>("number of frames averaged for each poke", limits::kPokeFrames)
        .mandatory()};

struct SlmShow {
  HologramKind pattern = HologramKind::sensor;
};
template <>
inline constexpr auto kTable<SlmShow> =
    Fields{"SlmShow", field<&SlmShow::pattern>(
                          "sensor: the wavefront sensor; grating: base grating and correction "
                          "only, for using the corrected beam; flat: flatness map only; identify: "
                          "a test image that shows which screen is the SLM and how it is oriented")
                          .among(kShowablePatterns)
                          .mandatory()};

struct LoopOpen {
  bool keep = true;
};
template <>
inline constexpr auto kTable<LoopOpen> =
    Fields{"LoopOpen", field<&LoopOpen::keep>("true: keep the correction; false: clear it")};

struct LoopPause {
  bool paused = true;
};
template <>
inline constexpr auto kTable<LoopPause> =
    Fields{"LoopPause", field<&LoopPause::paused>("true: hold the correction; false: go on")};

struct LoopIdentify {
  double seconds = 30.0;
};
template <>
inline constexpr auto kTable<LoopIdentify> =
    Fields{"LoopIdentify", field<&LoopIdentify::seconds>("time to watch the disturbance, seconds",
                                                         limits::kIdentifyS)};

}  // namespace ovws
