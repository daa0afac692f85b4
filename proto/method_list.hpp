/// The lists of all control methods and streams. JSON Schemas (daemon/shared/schemas) and the
/// Python client's methods are generated from them.
#pragma once

#include "proto/field.hpp"
#include "proto/methods.hpp"

namespace ovws {

inline constexpr EntryList kMethods{kAberrationClear,
                                    kAberrationGet,
                                    kAberrationSequence,
                                    kAberrationSet,
                                    kArrayFit,
                                    kCalibrationClear,
                                    kCalibrationGet,
                                    kCalibrationRun,
                                    kCalibrationSet,
                                    kCameraAutoExposure,
                                    kCameraGet,
                                    kCameraGrab,
                                    kCameraList,
                                    kCameraSelect,
                                    kCameraSet,
                                    kConfigGet,
                                    kConfigSave,
                                    kCorrectionClear,
                                    kCorrectionGet,
                                    kCorrectionSet,
                                    kCorrectorClear,
                                    kCorrectorGet,
                                    kCorrectorSet,
                                    kFlatnessClear,
                                    kFlatnessGet,
                                    kFlatnessRun,
                                    kFocusRun,
                                    kJobCancel,
                                    kJobGet,
                                    kLatticeList,
                                    kLatticePrepare,
                                    kLatticeRemove,
                                    kLatticeUse,
                                    kLoopClose,
                                    kLoopGet,
                                    kLoopIdentify,
                                    kLoopModel,
                                    kLoopOpen,
                                    kLoopPause,
                                    kLutClear,
                                    kLutGet,
                                    kLutRun,
                                    kMapRun,
                                    kRecordEstimate,
                                    kRecordGet,
                                    kRecordList,
                                    kRecordStart,
                                    kRecordStop,
                                    kReferenceClear,
                                    kReferenceDelete,
                                    kReferenceGet,
                                    kReferenceGive,
                                    kReferenceList,
                                    kReferenceLoad,
                                    kReferenceSave,
                                    kReferenceSet,
                                    kReferenceTake,
                                    kRefineGet,
                                    kRefineSet,
                                    kRegistrationClear,
                                    kRegistrationGet,
                                    kRegistrationRun,
                                    kSensorGet,
                                    kSensorSet,
                                    kSlmOutputs,
                                    kSlmPresent,
                                    kSlmSet,
                                    kSlmSettle,
                                    kSlmShow,
                                    kSlmVerify,
                                    kSystemDescribe,
                                    kSystemStatus};

inline constexpr EntryList kStreams{
    stream<WavefrontMessage>("wavefront", "Modes of each processed frame."),
    stream<SpotsMessage>("spots",
                         "Spots of each processed frame: JSON as `wavefront` without the modes; "
                         "then N x 6 float32, rows by subaperture."),
    stream<CorrectorMessage>("corrector",
                             "Commands of each processed frame for an external corrector, once "
                             "corrector.set was called: JSON as `wavefront` without the modes; "
                             "then one float32 for each actuator, if the frame is valid."),
    stream<ImageMessage>("image",
                         "Camera images at the image rate, always the newest frame, on the image "
                         "endpoint: JSON; then rows x cols pixels without padding."),
    stream<PhaseMessage>("phase",
                         "Wavefront map over the pupil at the image rate, on the image endpoint: "
                         "JSON; then rows x cols float32, waves, NaN outside the pupil."),
    stream<RefinedMessage>("refined",
                           "Maximum-likelihood fit of the diffraction model to every pixel of a "
                           "frame; published when the fit has ended."),
    stream<StreamedStatus>("status",
                           "Status of the daemon, once a second and immediately on change."),
    stream<EventMessage>("event", "Events: state changes, faults, progress of jobs.")};

}  // namespace ovws
