/// All control methods: name, types and description. The handlers are in daemon/ovwsd/control. Add
/// a method to the list in proto/method_list.hpp, too.
#pragma once

#include "proto/messages.hpp"
#include "proto/method.hpp"
#include "proto/requests.hpp"
#include "proto/tables/devices.hpp"

namespace ovws {

// Structs of results and of some params are in proto/tables, StatusMessage in
// proto/status_message.hpp, Config in config/config.hpp. Include only the tables that you use: each
// takes up to a second to compile.
struct ArrayFitReport;
struct CameraGrab;
struct CameraReport;
struct CameraSetReport;
struct Config;
struct ConfigSave;
struct CorrectorSet;
struct Description;
struct FlatnessReport;
struct GrabReport;
struct KnownCalibration;
struct KnownCorrector;
struct KnownReference;
struct KnownRegistration;
struct LatticeInUse;
struct LatticeList;
struct LatticeName;
struct LatticePrepare;
struct LutReport;
struct PresentReport;
struct RecordingList;
struct ReferenceList;
struct ReferenceName;
struct RefineReport;
struct RefineSetReport;
struct SavedReport;
struct SensorReport;
struct SensorSetReport;
struct ShowReport;
struct SlmPresent;
struct StatusMessage;
struct StreamedStatus;
struct VerifyReport;

inline constexpr auto kAberrationClear = method<Nothing, AberrationReport>(
    "aberration.clear", "Removes the introduced aberration, or ends a sequence.");
inline constexpr auto kAberrationGet =
    method<Nothing, AberrationReport>("aberration.get", "Returns the introduced aberration.");
inline constexpr auto kAberrationSequence = method<AberrationSequence, AberrationReport>(
    "aberration.sequence",
    "Shows a sequence of patterns on a DMD in its pattern mode: each is the sensor's hologram with "
    "its own introduced aberration, in place of that of aberration.set. The camera takes a frame "
    "of "
    "each; messages tell its pattern. A dark pattern marks the beginning of each cycle. Refused "
    "without a pattern mode, without a triggered camera, and while the loop is closed. "
    "aberration.set and aberration.clear end it.");
inline constexpr auto kAberrationSet = method<ModesSet, AberrationReport>(
    "aberration.set",
    "Replaces the introduced aberration. No mode may be given twice. The result is RMS-normalised, "
    "whatever norm was given.");
inline constexpr auto kArrayFit = method<ArrayFit, JobNumber>(
    "array.fit",
    "Measures depth and shift of the spiral plates of a fixed array from the shapes of its spots. "
    "They are stored with the registration, used for rendering spots, and kept by the next "
    "registration.run; registration.clear forgets them. A reference must be taken again. Returns "
    "at once; the job's result are the numbers.");
inline constexpr auto kCalibrationClear =
    method<Nothing, KnownCalibration>("calibration.clear",
                                      "Deletes the calibration of the current sensor, also on "
                                      "disk; the slopes operator is then active.");
inline constexpr auto kCalibrationGet = method<Nothing, KnownCalibration>(
    "calibration.get",
    "Returns the properties of the interaction (poke) matrix that was measured for the current "
    "sensor, compared with the model's; or nulls.");
inline constexpr auto kCalibrationRun = method<CalibrationRun, JobNumber>(
    "calibration.run",
    "Measures the interaction (poke) matrix: how far each mode moves each spot. Each mode is shown "
    "with both signs on top of the aberration that is shown. Returns at once; the job's result is "
    "that of calibration.get, and the matrix is active from then on (operator measured), unless "
    "the "
    "tracker is fit.");
inline constexpr auto kCalibrationSet =
    method<CalibrationSet, KnownCalibration>(
        "calibration.set",
        "Takes an interaction (poke) matrix that a client has measured with a corrector of its "
        "own, "
        "in place of calibration.run: it is stored, used and deleted as the matrix of that method. "
        "A spot whose rows are all 0 is lost. Refused with the tracker fit, and if a mode is not "
        "determined or its standard error exceeds a tenth of its signal.")
        .taking(
            "float32, little-endian, twice 2N x Z by rows x, y of each subaperture: the "
            "displacement by each mode, camera pixels per RMS-normalised wave, and its "
            "standard error");
inline constexpr auto kCameraAutoExposure = method<AutoExposure, JobNumber>(
    "camera.auto_exposure",
    "Changes the exposure until most spots reach a fraction of full scale, or the brightest spot "
    "reaches 95 %; lowers the gain if the shortest exposure is still too bright. Works with every "
    "pattern that the SLM shows. Returns at once; the job's result is the settings in use. If the "
    "job fails or is cancelled, the previous exposure and gain are restored.");
inline constexpr auto kCameraGet = method<Nothing, CameraReport>(
    "camera.get", "Returns the camera's settings and its current limits.");
inline constexpr auto kCameraGrab =
    method<CameraGrab, GrabReport>(
        "camera.grab",
        "Returns camera frames, each with its stamp: those exposed under a hologram, or the next "
        "ones. They are the newest at each time, not every frame of a fast camera. Fails if the "
        "hologram is replaced before there are enough.")
        .giving("pixels of the images without padding, as dtype and shape say");
inline constexpr auto kCameraList = method<Nothing, CameraList>(
    "camera.list",
    "Discovers the cameras on all networks and USB buses, which takes about a second. Empty if "
    "camera.driver has no discovery.");
inline constexpr auto kCameraSelect = method<CameraSelect, CameraReport>(
    "camera.select",
    "Disconnects the camera and connects to this one, with the present settings as far as its "
    "limits allow. If it is not there or cannot be opened, the former one stays in use. "
    "config.save keeps the choice.");
inline constexpr auto kCameraSet = method<CameraSet, CameraSetReport>(
    "camera.set",
    "Changes camera settings, all or nothing; omitted keys stay unchanged. The streams continue. "
    "The camera may allow less than the ranges stated here: its limits are in the result and in "
    "the error.");
inline constexpr auto kConfigGet = method<Nothing, Config>(
    "config.get",
    "Returns the effective configuration: the file's keys, all defaults, and later changes.");
inline constexpr auto kConfigSave = method<ConfigSave, SavedReport>(
    "config.save",
    "Saves the settings in use that differ from the configuration file, atomically, to an overlay "
    "in the state directory. The daemon applies the overlay over the file at its start and at "
    "every reload.");
inline constexpr auto kCorrectionClear = method<Nothing, ModesReport>(
    "correction.clear", "Removes the correction. Refused while the loop is closed.");
inline constexpr auto kCorrectionGet = method<Nothing, ModesReport>(
    "correction.get",
    "Returns the correction that is subtracted from the hologram, by the loop or by a user.");
inline constexpr auto kCorrectionSet =
    method<ModesSet, ModesReport>("correction.set",
                                  "Subtracts these modes from the hologram, in place of the "
                                  "previous correction. Refused while the loop is closed.");
inline constexpr auto kCorrectorClear = method<Nothing, KnownCorrector>(
    "corrector.clear", "Deletes the matrix of the external corrector: no commands are published.");
inline constexpr auto kCorrectorGet = method<Nothing, KnownCorrector>(
    "corrector.get",
    "Returns the properties of the external corrector's matrix, and whether it is in use; or "
    "nulls.");
inline constexpr auto kCorrectorSet =
    method<CorrectorSet, KnownCorrector>(
        "corrector.set",
        "Replaces the matrix of the external corrector, such as a deformable mirror that a client "
        "drives: from now on, each valid frame is published as commands, the matrix times its "
        "coefficients, in the stream corrector. The daemon integrates nothing. The matrix does not "
        "survive a restart of the daemon.")
        .taking(
            "float32, little-endian, actuators x modes by rows: commands per RMS-normalised "
            "wave, in any unit");
inline constexpr auto kFlatnessClear =
    method<Nothing, FlatnessReport>("flatness.clear",
                                    "Deletes the measured flatness, also on disk; only that of the "
                                    "configured file, if any, is then active.");
inline constexpr auto kFlatnessGet = method<Nothing, FlatnessReport>(
    "flatness.get", "Returns the measured flatness of the SLM as modes.");
inline constexpr auto kFlatnessRun = method<FlatnessRun, JobNumber>(
    "flatness.run",
    "Measures the flatness error of the SLM and of the optics between SLM and camera as modes, "
    "from a single spot whose aperture is moved over the whole pupil; shows their opposite, and "
    "scans again until the modes converge. Requires a registration. Returns at once; the job's "
    "result is that of flatness.get, and is active from then on. Uses a shorter exposure for the "
    "time of the job if the spot is saturated.");
inline constexpr auto kFocusRun = method<FocusRun, JobNumber>(
    "focus.run",
    "Measures defocus, astigmatism, coma and the other modes up to radial order 4 of the light "
    "over the whole pupil, as far as the places of the spots determine them, and how far the "
    "camera is from the focus: fits the diffraction model to the mean image of the spots. The "
    "modes are what is left beyond the flatness in use. Requires a "
    "registration. Returns at once; the job's result is defocus_waves, camera_shift_mm and the "
    "modes, and no setting is changed.");
inline constexpr auto kJobCancel = method<JobNumber, JobReport>(
    "job.cancel", "Cancels a running job; a job that has ended stays unchanged.");
inline constexpr auto kJobGet =
    method<JobNumber, JobReport>("job.get", "Returns the state and progress of a job.");
inline constexpr auto kLatticeList = method<Nothing, LatticeList>(
    "lattice.list",
    "Lists the prepared lattices, which of them is in use, and whether each could be used now.");
inline constexpr auto kLatticePrepare = method<LatticePrepare, JobNumber>(
    "lattice.prepare",
    "Prepares lattices for lattice.use: shows each in turn, finds its exposure, and takes its "
    "reference and, if requested, its calibration. Nothing is introduced meanwhile; the correction "
    "stays. At most 8 are prepared; a name that exists is prepared again. Returns at once; sensor, "
    "aberration and exposure are as before when the job ends, fails or is cancelled, and the "
    "lattices that it has finished stay prepared.");
inline constexpr auto kLatticeRemove = method<LatticeName, LatticeList>(
    "lattice.remove",
    "Removes a prepared lattice. The sensor, its reference and its calibration stay.");
inline constexpr auto kLatticeUse = method<LatticeName, LatticeInUse>(
    "lattice.use",
    "Switches to a prepared lattice in one step: its exposure, its hologram with the aberration "
    "and the correction in use, its reference and its calibration. Refused while the loop is "
    "closed, and if its reference does not apply any more; nothing changes then.");
inline constexpr auto kLoopClose = method<LoopSettings, LoopReport>(
    "loop.close",
    "Closes the loop: an integrator subtracts the measured modes from the hologram, one step per "
    "settled and valid frame, starting from the correction that is shown. Requires a reference. "
    "The loop opens by itself, with an event, when it cannot continue.");
inline constexpr auto kLoopGet =
    method<Nothing, LoopReport>("loop.get", "Returns the state of the loop.");
inline constexpr auto kLoopIdentify = method<LoopIdentify, JobNumber>(
    "loop.identify",
    "Watches the disturbance, with the loop open or closed, and identifies it mode by mode for the "
    "control laws optimised and predictor. Returns at once; the job's result is that of "
    "loop.model, and loops that are closed from then on use it.");
inline constexpr auto kLoopModel = method<Nothing, KnownLoopModel>(
    "loop.model",
    "Returns what loop.identify found: each mode's disturbance, and the residual and gain margin "
    "that each control law is expected to have.");
inline constexpr auto kLoopOpen = method<LoopOpen, LoopReport>(
    "loop.open", "Opens the loop. The correction stays as it is, or is cleared.");
inline constexpr auto kLoopPause = method<LoopPause, LoopReport>(
    "loop.pause",
    "Pauses the closed loop: it holds its correction and stays closed, whatever the frames show. "
    "Or goes on.");
inline constexpr auto kLutClear =
    method<Nothing, LutReport>("lut.clear",
                               "Deletes the measured look-up table, also on disk. The table of the "
                               "configured file, or the linear one, becomes active.");
inline constexpr auto kLutGet =
    method<Nothing, LutReport>("lut.get",
                               "Returns the active look-up table, its source and, if it was "
                               "measured, the SLM's phase for each grey level.");
inline constexpr auto kLutRun = method<LutRun, JobNumber>(
    "lut.run",
    "Measures the SLM's phase response to grey levels: two patches of the pupil with binary "
    "gratings interfere on the camera, one of them with each grey level in turn. Returns at once; "
    "the job's result is that of lut.get, and is active from then on. Uses another exposure for "
    "the time of the job if the spot is saturated or invisible.");
inline constexpr auto kMapRun = method<MapRun, JobNumber>(
    "map.run",
    "Measures the wavefront error of the SLM and of the optics as a fine map over the pupil: shows "
    "patterns of known defocus and astigmatism over the whole pupil, and retrieves the phase from "
    "their images. Requires a registration. Returns at once; the job's result is the map beside "
    "the "
    "flatness in use. With apply it becomes the flatness, as by flatness.run. Uses a shorter "
    "exposure for the time of the job if pixels are saturated.");
inline constexpr auto kRecordEstimate = method<RecordEstimate, RecordSize>(
    "record.estimate",
    "Returns how large a recording with the current settings would become, without its documents, "
    "and how long the disk has space for it.");
inline constexpr auto kRecordGet = method<Nothing, RecordReport>(
    "record.get", "Returns the state of the current or the last recording.");
inline constexpr auto kRecordList = method<Nothing, RecordingList>(
    "record.list", "Lists the recordings in the daemon's folder, the newest first.");
inline constexpr auto kRecordStart = method<RecordStart, RecordReport>(
    "record.start",
    "Records every frame from now on into a file: its measurement, its timestamps, all settings "
    "that apply to it, and its image.");
inline constexpr auto kRecordStop = method<Nothing, RecordReport>(
    "record.stop", "Ends the recording; the file is complete when this returns.");
inline constexpr auto kReferenceClear = method<Nothing, KnownReference>(
    "reference.clear",
    "Deletes the reference, also on disk; if that fails, nothing changes. Frames are not valid "
    "until a new reference is taken.");
inline constexpr auto kReferenceDelete = method<ReferenceName, ReferenceList>(
    "reference.delete", "Deletes a saved reference. The active reference stays.");
inline constexpr auto kReferenceGet =
    method<Nothing, KnownReference>("reference.get", "Returns the active reference, or nulls.");
inline constexpr auto kReferenceGive =
    method<ReferenceGive, KnownReference>(
        "reference.give",
        "Makes positions the reference that a client has measured, for example with known tilts of "
        "the light, in place of reference.take. Refused with the tracker fit, which needs an "
        "image.")
        .taking(
            "float32, little-endian, 2 x N x 2: [x, y] of each spot in camera pixels of the region "
            "of interest, NaN: lost; then their standard errors");
inline constexpr auto kReferenceList = method<Nothing, ReferenceList>(
    "reference.list", "Lists the saved references, and whether each fits the present sensor.");
inline constexpr auto kReferenceLoad = method<ReferenceName, KnownReference>(
    "reference.load",
    "Makes a saved reference the active one, in place of the present one; its time and origin "
    "stay. "
    "Refused if it does not fit the present sensor, camera, region, LUT or flatness.");
inline constexpr auto kReferenceSave = method<ReferenceName, ReferenceList>(
    "reference.save",
    "Saves the active reference under a name, at most 32 of them. An existing name is refused.");
inline constexpr auto kReferenceSet = method<ReferenceSet, KnownReference>(
    "reference.set",
    "Makes the predicted spot positions of the configuration, or of the active registration, the "
    "reference: the coefficients are then absolute and include what the bench itself adds, such as "
    "misalignment. Replaces the active reference until the next reference.take or "
    "reference.clear.");
inline constexpr auto kReferenceTake = method<ReferenceTake, JobNumber>(
    "reference.take",
    "Takes a reference: averages the spot positions of the next frames, from which displacements "
    "then count. Refused if more than a tenth of the spots are saturated, if the spots move "
    "meanwhile, or if an aberration is introduced. Returns at once; the job reports the outcome.");
inline constexpr auto kRefineGet =
    method<Nothing, RefineReport>("refine.get",
                                  "Returns the settings of the refinement: whether it is enabled, "
                                  "its rate, and the camera's gain and noise.");
inline constexpr auto kRefineSet = method<RefineSet, RefineSetReport>(
    "refine.set",
    "Changes the settings of the refinement, all or nothing; omitted keys stay unchanged. A fit "
    "that is running with other settings is not published. DN are those of the camera's pixel "
    "format, and are converted when it changes.");
inline constexpr auto kRegistrationClear = method<Nothing, KnownRegistration>(
    "registration.clear",
    "Deletes the registration; the configuration then defines where the camera sees which slope.");
inline constexpr auto kRegistrationGet =
    method<Nothing, KnownRegistration>("registration.get",
                                       "Returns the measured registration (the map from slopes to "
                                       "camera pixels). All values are null if none was measured "
                                       "and the configuration's geometry is used.");
inline constexpr auto kRegistrationRun = method<RegistrationRun, JobNumber>(
    "registration.run",
    "Measures the registration, the map from slopes to camera pixels: the base subaperture alone "
    "is shown with known gratings, and its spot is found. Returns at once; the job's result is "
    "that of registration.get, and is active from then on. Uses a shorter exposure for the "
    "time of the job if the spot is saturated.");
inline constexpr auto kSensorGet = method<Nothing, SensorReport>(
    "sensor.get", "Returns the sensor shown on the SLM and its tracking settings.");
inline constexpr auto kSensorSet = method<SensorSet, SensorSetReport>(
    "sensor.set",
    "Changes sensor and tracking settings, all or nothing; omitted keys stay unchanged. A change "
    "of geometry, charge or tracker deactivates the reference, which is active again when the same "
    "settings return.");
inline constexpr auto kSlmOutputs = method<Nothing, OutputList>(
    "slm.outputs",
    "Lists the outputs of the X server and whether each could drive the SLM. Refused on other "
    "display systems.");
inline constexpr auto kSlmPresent =
    method<SlmPresent, PresentReport>(
        "slm.present",
        "Shows a picture of the client in place of the sensor, and answers when the SLM has "
        "settled. The first one begins a presentation, a job that holds the sensor; later requests "
        "name it, and each begins the lease again. When the lease ends, or with job.cancel, the "
        "previous hologram returns. The camera's settings may be changed meanwhile.")
        .taking("pixels of the picture without padding, as dtype and shape say");
inline constexpr auto kSlmSet = method<SlmSet, SlmSettings>(
    "slm.set",
    "Changes the SLM's output or settle time, all or nothing; omitted keys stay unchanged. Another "
    "output is opened at once; if it cannot drive the SLM, the former one stays in use. The result "
    "is the settings in use; config.save keeps them.");
inline constexpr auto kSlmSettle = method<SettleRun, JobNumber>(
    "slm.settle",
    "Measures the settle time of the SLM, from the display's acceptance of an image until the "
    "light on the camera is stable: a spot is moved to and fro, and every frame is watched, "
    "settled or not. Returns at once; the job's result is the time and a proposed slm.settle_ms. "
    "Outliers, more than three standard deviations above the median (by the median absolute "
    "deviation), are counted and left out. No setting is changed.");
inline constexpr auto kSlmShow =
    method<SlmShow, ShowReport>("slm.show", "Selects the pattern that the SLM shows.");
inline constexpr auto kSlmVerify = method<Nothing, VerifyReport>(
    "slm.verify",
    "Reads back the pixels of the SLM's output and compares them with the hologram presented last. "
    "A difference also causes an event of kind slm.");
inline constexpr auto kSystemDescribe = method<Nothing, Description>(
    "system.describe",
    "Returns all methods and streams with their JSON Schemas, and the versions.");
inline constexpr auto kSystemStatus =
    method<Nothing, StatusMessage>("system.status", "Returns the contents of the status message.");

}  // namespace ovws
