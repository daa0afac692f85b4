/// Measurement procedures of the bench: calibration, exposure, flatness, focus, lattices,
/// LUT, reference, registration and settle time. Each procedure also fails with the errors of
/// Bench.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "core/control/loop_model.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/settle_time.hpp"
#include "core/spots/plate_fit.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/library/calibration.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/sensor/prepared_lattices.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/focus.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/map.hpp"
#include "proto/tables/params.hpp"

namespace ovws {

/// Whether `array.fit` can run. Errc::refused: the sensor is no fixed array with spiral plates, or
/// its array was not found yet.
Result<void> can_fit_array(const SensorSnapshot& sensor);
/// `array.fit`: measures the spiral plates from the mean image of `frames` frames. Errors: those of
/// can_fit_array, check_average and fit_plate; Errc::refused, field "camera": the camera's settings
/// changed.
Result<PlateFit> measure_plate(Bench& bench, int frames);

/// `calibration.run`: measures the interaction matrix by push-pull poking. Shows each mode with
/// both signs on top of the current aberration, and averages the spots of settled frames. At the
/// end the SLM shows the aberration without a poke. An event warns of spots and modes that it lacks
/// and of modes whose response was not steady. Errors: those of interaction_matrix;
/// Errc::invalid, field "modes": the lattice does not determine a requested mode; Errc::refused,
/// field "modes": all modes were requested, spots were lost, and a mode cannot be measured.
Result<MeasuredCalibration> measure_calibration(Bench& bench, const CalibrationRun& run);

/// `camera.auto_exposure`: changes the exposure until most spots reach the target, within 5 % of
/// it, or 10 % after eight looks, or as near as the camera's steps allow. Lowers the gain if the
/// shortest exposure is too bright. The spots are those in the mean of three frames
/// (judge_exposure). Keeps the camera's settings. Errc::refused, with the
/// field that limits the exposure: no light, too dark, too bright, or the brightness does not
/// follow the exposure.
Result<AutoExposureReport> set_exposure(Bench& bench, const AutoExposure& asked);
/// The same, but the camera's previous settings return when the job ends.
Result<AutoExposureReport> find_exposure(Bench& bench, const AutoExposure& asked);

/// `flatness.run`: measures the flatness error of the SLM and the optics by scanning a single
/// aperture with a bright spot over the pupil (ScanGrid). All positions use the same grating, so
/// the spot's displacements are the local slopes. Fits the modes (ScanFit), shows them with
/// opposite sign, and scans again until the modes no longer change. The aperture is smaller than a
/// subaperture, so that the spot is about as bright as the sensor's vortices. The result includes
/// the previously active flatness. It has no tilts, which belong to the registration; its origin is
/// not set. Errors: those of ScanFit::fit. Errc::refused: no registration, a correction is active,
/// or a flatness of another pupil is active; no wavefront explains the positions, or the iteration
/// does not converge.
Result<MeasuredFlatness> measure_flatness(Bench& bench, int frames);

/// `focus.run`: measures the modes j = 3 to 14 of the light over the whole pupil, as far as the
/// places of the spots determine them, and the camera's distance from the focus
/// (camera_shift_mm_per_wave): fits the diffraction model to the mean image of the sensor's spots,
/// without an introduced aberration. Active flatness is part of the hologram; the result is what is
/// left. Errors: those of can_scan and check_average; Errc::refused: too few spots are found (field
/// "camera.exposure_us") or determine no defocus, or no wavefront explains the image.
Result<FocusReport> measure_focus(Bench& bench, const FocusRun& run);

/// Result of map.run with the maps that its report contains encoded.
struct BenchMap {
  Image<float> error;            ///< waves, cells x cells over the pupil's square; NaN outside
  Image<float> half_difference;  ///< of the maps from the first and the second images
  double misfit = 0.0, resolution_px = 0.0;
  MapReport report;
};
/// `map.run`: measures the wavefront error of the bench as a fine map. Shows patterns of known
/// defocus and astigmatism over the whole pupil, each twice; light outside the pupil is diffracted
/// out of sight. Retrieves a map from each half of the images (PhaseRetrieval): their mean is the
/// result, their difference its noise. Errors: those of PhaseRetrieval; Errc::refused: no
/// registration, a correction is active, a flatness of another pupil is active, a colour camera,
/// the camera's region is too small, the images are too dark, no wavefront explains them, or both
/// maps disagree.
Result<BenchMap> measure_map(Bench& bench, const MapRun& run);
/// The map as a flatness: modes, and the fine rest. Its origin is not set.
MeasuredFlatness flatness_of(const BenchMap& map);

/// `lattice.prepare`: shows each lattice in turn without an introduced aberration, finds its
/// exposure, takes its reference and, if requested, its calibration, and keeps it in `prepared`.
/// The job can be cancelled until it ends; finished lattices stay. Returns the job's result.
/// Errors: those of find_exposure, take_reference and measure_calibration, with the lattice's name.
Result<nlohmann::json> prepare_lattices(Bench& bench, const LatticePrepare& asked,
                                        PreparedLattices& prepared);

/// `loop.identify`: watches the disturbance, residuals plus shown corrections, for `seconds`. The
/// loop may be open or closed. Frames of one hologram within `sample_s` are averaged.
/// Errc::refused: too few valid frames came, or the sensor changed meanwhile. Errc::unavailable: no
/// frames came.
Result<DisturbanceSeries> watch_disturbance(Bench& bench, double seconds, double sample_s);
constexpr double kWatchingShare = 0.8;  ///< of the job's progress
/// Estimated timing of a loop on this bench that waits for a frame of the newest hologram. A step
/// takes settle time, exposure, transfer and half a frame period, rounded up to whole refreshes of
/// the display. The frame begins half a frame period after the hologram has settled.
LoopTiming estimated_timing(const Config& config, const CameraSettings& camera, double refresh_hz);

/// `lut.run`: measures the SLM's phase response by interference of two patches of the pupil
/// (core/optics/grey_fringe.hpp). One patch shows all grey levels, first upwards and then
/// downwards; the other patch shows a fixed level. The patches are as large as possible without
/// saturating the camera. The result's origin is not set. Errors: those of phase_response;
/// Errc::refused: the spot is saturated or too dark.
Result<MeasuredLut> measure_lut(Bench& bench, const LutRun& run);

/// Checks whether a reference can be taken. Errors: those of check_array_found. Errc::refused: the
/// SLM does not show the sensor. Errc::refused, field "allow_aberration": an aberration is
/// introduced, which would become part of the reference.
Result<void> can_take_reference(const SensorSnapshot& sensor, const ReferenceTake& take);

/// `reference.take`: averages the spots of settled frames and the pixels of some of these frames.
/// Activates the reference and returns the job's result; for `step` see Bench::use. Errors: those
/// of can_take_reference and use_reference; Errc::refused, field "camera": the camera's settings
/// changed during the job.
Result<nlohmann::json> take_reference(Bench& bench, const ReferenceTake& take,
                                      Bench::Step step = Bench::Step::last);

/// `registration.run`: registers the camera to the SLM. Shows the base subaperture alone with
/// several gratings, which move its spot over most of the field. Then fits an affine map to the
/// spot's positions. Works for any rotation, parity and scale. The result's base spot is in pixels
/// of the camera's whole sensor. Errc::refused: the spot is not found, or no affine map fits its
/// positions.
Result<Registration> measure_registration(Bench& bench, int frames);
/// `registration.run` of a fixed array: finds its lenslets in the mean of `frames` images. Errors:
/// those of find_lenslets; Errc::refused, field "camera": no lenslet in the pupil is lit;
/// "camera.exposure_us": more than a tenth of the spots are saturated at every exposure, or three
/// are and no lattice is found. A spot with one saturated pixel counts as unsaturated.
Result<Registration> measure_array(Bench& bench, int frames);

/// `slm.settle`: measures the SLM's settle time. Moves one spot between two places, and records the
/// intensity at each place in every frame, settled or not. Times count from the moment the display
/// presented each hologram. At most two moves that step_time refuses for `watch_ms` are repeated,
/// each with an event.
/// Errors: those of Bench::check_shown and step_time.
Result<SettleTime> measure_settle(Bench& bench, const SettleRun& run);

}  // namespace ovws
