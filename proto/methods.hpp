/// The list of all control methods and streams: name, types and description. JSON Schemas
/// (daemon/shared/schemas) and the Python client's methods are generated from it; the handlers are
/// in daemon/ovwsd/control.
#pragma once

#include <tuple>

#include "proto/messages.hpp"
#include "proto/requests.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/experiment.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {

struct Config;  // config/config.hpp

/// A control method with params P and result R.
template <class P, class R>
struct Method {
  using Params = P;
  using Result = R;
  const char* name;
  const char* description;
};
template <class P, class R>
constexpr Method<P, R> method(const char* name, const char* description) {
  return {name, description};
}

/// A stream topic; M is the JSON part of its messages.
template <class M>
struct Stream {
  using Message = M;
  const char* topic;
  const char* description;
};
template <class M>
constexpr Stream<M> stream(const char* topic, const char* description) {
  return {topic, description};
}

inline constexpr auto kAberrationClear =
    method<Nothing, ModesReport>("aberration.clear", "Takes the wavefront added on purpose away.");
inline constexpr auto kAberrationGet =
    method<Nothing, ModesReport>("aberration.get", "The wavefront added on purpose.");
inline constexpr auto kAberrationSet = method<ModesSet, ModesReport>(
    "aberration.set",
    "Replaces the wavefront added on purpose. No mode may be given twice. The answer is in RMS "
    "normalisation whatever was given.");
inline constexpr auto kCalibrationClear = method<Nothing, KnownCalibration>(
    "calibration.clear",
    "Forgets the calibration of the sensor as it is now, on the disk, too: its matrix is then the"
    " slopes'.");
inline constexpr auto kCalibrationGet = method<Nothing, KnownCalibration>(
    "calibration.get",
    "The interaction matrix that was measured for the sensor as it is now, in figures, against "
    "the model's; or nulls.");
inline constexpr auto kCalibrationRun = method<CalibrationRun, JobNumber>(
    "calibration.run",
    "Measures how far each mode moves each spot: it is shown with both signs, on top of the "
    "aberration that is shown. Answers at once; the job's result is that of calibration.get, and "
    "modes are read with it from then on (operator measured).");
inline constexpr auto kCameraGet =
    method<Nothing, CameraReport>("camera.get", "What is in use and what the camera allows.");
inline constexpr auto kCameraSet = method<CameraSet, CameraSetReport>(
    "camera.set",
    "All or nothing; what is left out stays. The stream survives it. The camera may allow less "
    "than the ranges here: its limits are in the result and in the error.");
inline constexpr auto kConfigGet = method<Nothing, Config>(
    "config.get",
    "The effective configuration: the file's keys, every default, and what was set since.");
inline constexpr auto kConfigSave = method<Nothing, SavedReport>(
    "config.save",
    "Saves the settings in use that differ from the configuration file, atomically, to an overlay"
    " in the state directory. The daemon lays it over the file at its start and at every reload.");
inline constexpr auto kCorrectionClear = method<Nothing, ModesReport>(
    "correction.clear", "Nothing is subtracted any more. Not while the loop is closed.");
inline constexpr auto kCorrectionGet = method<Nothing, ModesReport>(
    "correction.get", "What is subtracted from the hologram, by the loop or by a person.");
inline constexpr auto kCorrectionSet = method<ModesSet, ModesReport>(
    "correction.set",
    "Subtracts these modes from the hologram, in place of the correction of before. Not while the"
    " loop is closed.");
inline constexpr auto kExperimentCell = method<ExperimentCell, CellReport>(
    "experiment.cell", "One measured cell of the gain sweep, frame by frame.");
inline constexpr auto kExperimentGainSweep = method<GainSweepRun, JobNumber>(
    "experiment.gain_sweep",
    "The paper's comparison: the residual variance of each arm against the camera's gain, at the "
    "exposure that is set, with aberrations shown on purpose. First a reference of each arm "
    "without an aberration, then cell by cell, a cell being one arm with one aberration at one "
    "gain. Answers at once; experiment.get and experiment.cell tell what was measured so far. The"
    " same params on the same bench go on with the cells that are missing, also after a cancel or"
    " a restart, if the spots of the run's first reference stand within lambda/(20 d) of where "
    "they stood; else the job is refused and the cells stay. Who asks for the run that is being "
    "measured is given its job. Gain, sensor and aberration are put back at the end, the user's "
    "reference is not touched.");
inline constexpr auto kExperimentGet = method<Nothing, KnownExperiment>(
    "experiment.get",
    "The gain sweep that was asked for last, and what was measured of it so far; or nulls.");
inline constexpr auto kFlatnessClear = method<Nothing, FlatnessReport>(
    "flatness.clear",
    "From now on the flatness is that of the configuration's file alone, or none. The measured "
    "one is gone from the disk, too.");
inline constexpr auto kFlatnessGet = method<Nothing, FlatnessReport>(
    "flatness.get", "What was measured of the SLM's flatness, as modes.");
inline constexpr auto kFlatnessRun = method<FlatnessRun, JobNumber>(
    "flatness.run",
    "Reads the modes of the SLM's flatness, and of the optics between SLM and camera, from a lone"
    " spot whose aperture is moved all over the pupil; shows their opposite, and scans again "
    "until nothing changes. Needs a registration. Answers at once; the job's result is that of "
    "flatness.get, and in force from then on.");
inline constexpr auto kJobCancel = method<JobNumber, JobReport>(
    "job.cancel", "Ends a job that runs; one that has ended stays as it is.");
inline constexpr auto kJobGet = method<JobNumber, JobReport>("job.get", "How far a job is.");
inline constexpr auto kLoopClose = method<LoopSettings, LoopReport>(
    "loop.close",
    "From now on what is measured is subtracted from the hologram, a step a settled and valid "
    "frame, beginning from the correction that is shown. Needs a reference. The loop opens by "
    "itself, with an event, when it cannot go on.");
inline constexpr auto kLoopGet = method<Nothing, LoopReport>("loop.get", "How the loop does.");
inline constexpr auto kLoopOpen =
    method<LoopOpen, LoopReport>("loop.open", "The correction stays as it is, or is cleared.");
inline constexpr auto kLutClear = method<Nothing, LutReport>(
    "lut.clear",
    "From now on the look-up table is that of the configuration: its file's, or the linear one. "
    "The measured one is gone from the disk, too.");
inline constexpr auto kLutGet = method<Nothing, LutReport>(
    "lut.get",
    "The look-up table in force, where it comes from, and, if it was measured, the SLM's phase "
    "against its grey level.");
inline constexpr auto kLutRun = method<LutRun, JobNumber>(
    "lut.run",
    "Measures the phase of the SLM's grey levels: two patches of the pupil with binary gratings "
    "beat with each other on the camera, one of them with each grey level in turn. Answers at "
    "once; the job's result is that of lut.get, and in force from then on.");
inline constexpr auto kRecordGet =
    method<Nothing, RecordReport>("record.get", "What is being recorded, or was last.");
inline constexpr auto kRecordStart = method<RecordStart, RecordReport>(
    "record.start",
    "Writes every frame from now on into a file: what was measured of it, its stamps, all that "
    "was in force, and its picture.");
inline constexpr auto kRecordStop = method<Nothing, RecordReport>(
    "record.stop", "Ends the recording; the file is whole when this answers.");
inline constexpr auto kReferenceClear = method<Nothing, KnownReference>(
    "reference.clear",
    "Forgets the reference; the stream is not valid until a new one is taken. It is forgotten on "
    "the disk, too; if that fails, nothing changes.");
inline constexpr auto kReferenceGet =
    method<Nothing, KnownReference>("reference.get", "The reference in use, or nulls.");
inline constexpr auto kReferenceSet = method<ReferenceSet, KnownReference>(
    "reference.set",
    "Positions count from where the configuration, or the registration in force, says that spots "
    "are, instead of from a reference that was taken: the coefficients then hold what the bench "
    "itself adds, its misalignment included. It takes the place of the reference in force, until "
    "the next reference.take or reference.clear.");
inline constexpr auto kReferenceTake = method<ReferenceTake, JobNumber>(
    "reference.take",
    "Averages the spots of the next frames as what displacements count from; refused if more than"
    " a tenth of the spots are saturated, if the spots move meanwhile, or if an aberration is "
    "introduced. Answers at once; the job tells how it ends.");
inline constexpr auto kRefineGet = method<Nothing, RefineReport>(
    "refine.get",
    "Whether frames are refined, how often, and how the camera makes numbers of electrons.");
inline constexpr auto kRefineSet = method<RefineSet, RefineSetReport>(
    "refine.set",
    "All or nothing; what is left out stays. What is being refined with other numbers is not "
    "published. DN are those of the camera's pixel format, and are converted when it changes.");
inline constexpr auto kRegistrationClear = method<Nothing, KnownRegistration>(
    "registration.clear", "From now on the configuration says where the camera sees which slope.");
inline constexpr auto kRegistrationGet = method<Nothing, KnownRegistration>(
    "registration.get",
    "Where the camera sees which slope, as measured; or nulls: then the configuration says it.");
inline constexpr auto kRegistrationRun = method<RegistrationRun, JobNumber>(
    "registration.run",
    "Measures where the camera sees which slope: the base subaperture alone is shown with known "
    "gratings, and its spot is found. Answers at once; the job's result is that of "
    "registration.get, and in force from then on.");
inline constexpr auto kSensorGet = method<Nothing, SensorReport>(
    "sensor.get", "The sensor shown on the SLM and how its spots are found.");
inline constexpr auto kSensorSet = method<SensorSet, SensorSetReport>(
    "sensor.set",
    "All or nothing; what is left out stays. A reference is set aside by a change of geometry, "
    "charge, tracker or (of matched) template, and is in force again when the same setting "
    "returns.");
inline constexpr auto kSlmSettle = method<SettleRun, JobNumber>(
    "slm.settle",
    "Measures how long the SLM takes from the display's taking a picture until the light on the "
    "camera stands: a spot is moved to and fro, and every frame is watched, settled or not. "
    "Answers at once; the job's result is the time, and the slm.settle_ms that it proposes: by "
    "the changes whose time is no outlier (more than three standard deviations above the median, "
    "by the median absolute deviation), with the number of those that are. Nothing is changed by "
    "it.");
inline constexpr auto kSlmShow = method<SlmShow, ShowReport>("slm.show", "What the SLM shows.");
inline constexpr auto kSlmVerify = method<Nothing, VerifyReport>(
    "slm.verify",
    "Reads back what stands on the SLM's output and compares it with the hologram that was "
    "presented last. A difference is also an event of kind slm.");
inline constexpr auto kSystemDescribe = method<Nothing, Description>(
    "system.describe", "All methods and streams with their JSON Schemas, and versions.");
inline constexpr auto kSystemStatus =
    method<Nothing, StatusMessage>("system.status", "The body of the status message.");

inline constexpr std::tuple kMethods{kAberrationClear,   kAberrationGet,   kAberrationSet,
                                     kCalibrationClear,  kCalibrationGet,  kCalibrationRun,
                                     kCameraGet,         kCameraSet,       kConfigGet,
                                     kConfigSave,        kCorrectionClear, kCorrectionGet,
                                     kCorrectionSet,     kExperimentCell,  kExperimentGainSweep,
                                     kExperimentGet,     kFlatnessClear,   kFlatnessGet,
                                     kFlatnessRun,       kJobCancel,       kJobGet,
                                     kLoopClose,         kLoopGet,         kLoopOpen,
                                     kLutClear,          kLutGet,          kLutRun,
                                     kRecordGet,         kRecordStart,     kRecordStop,
                                     kReferenceClear,    kReferenceGet,    kReferenceSet,
                                     kReferenceTake,     kRefineGet,       kRefineSet,
                                     kRegistrationClear, kRegistrationGet, kRegistrationRun,
                                     kSensorGet,         kSensorSet,       kSlmSettle,
                                     kSlmShow,           kSlmVerify,       kSystemDescribe,
                                     kSystemStatus};

inline constexpr std::tuple kStreams{
    stream<WavefrontMessage>("wavefront", "Published for each processed frame."),
    stream<SpotsMessage>(
        "spots", "JSON as `wavefront` without the modes; then N x 6 float32, rows by subaperture."),
    stream<ImageMessage>(
        "image",
        "Some of the frames, newest first, on the image endpoint; then rows x cols pixels without "
        "padding."),
    stream<PhaseMessage>(
        "phase",
        "The wavefront over the pupil at the image rate, on the image endpoint; then rows x cols "
        "float32, waves, NaN outside the pupil."),
    stream<RefinedMessage>("refined",
                           "Every pixel of a frame against the diffraction model, by maximum "
                           "likelihood; published when "
                           "a fit has ended, seconds after its frame."),
    stream<StreamedStatus>("status", "Once a second, and at once on change."),
    stream<EventMessage>("event", "State changes, faults, progress of jobs.")};

}  // namespace ovws
