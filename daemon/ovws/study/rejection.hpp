/// Disturbance rejection of a closed loop by frequency, from recordings of the sensor's modes: with
/// the loop open, and closed with each control law. Pure functions.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/control/loop_model.hpp"
#include "core/control/loop_settings.hpp"
#include "core/control/mode_law.hpp"
#include "core/control/spectrum.hpp"
#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

/// RMS over all frames of the root sum square of all modes, waves.
double rms_waves(const ModeSeries& recording);

struct RejectionPoint {
  double hz = 0.0, db = 0.0;
};

/// Rejection in dB: 10 lg of closed over open power, each summed over a third of an octave about
/// the frequency. Starts at the second frequency, because removing the mean reduces the first. Ends
/// at the last common frequency. Both spectra must have the same step_hz.
std::vector<RejectionPoint> rejection(const Spectrum& open, const Spectrum& closed);

/// Crossing frequency: the first one at which the rejection rises above `level_db`, interpolated in
/// log frequency. None: the rejection is above the level from the start, or never.
std::optional<double> crossing_hz(const std::vector<RejectionPoint>& rejection, double level_db);

/// Spectrum that a loop with this timing is expected to leave of the open loop's
/// (ModeLaw::transfer), summed over the modes. NaN above half of the step rate. `laws`: one for
/// each mode of the recording.
Spectrum expected_spectrum(const ModeSeries& open, double segment_s,
                           std::span<const std::unique_ptr<ModeLaw>> laws,
                           const LoopTiming& timing);

/// Noise floor of a spectrum, wave^2/Hz: the median of its upper quarter. It is the power of the
/// noise, or more if the disturbance reaches that far. 0 if the spectrum is empty.
double noise_floor_per_hz(const Spectrum& spectrum);

/// Rejection in a band from `from_hz` (included) to `to_hz` (excluded).
struct RejectionBand {
  double from_hz = 0.0, to_hz = 0.0;
  double db = 0.0;           ///< rejection: closed over open power
  double expected_db = 0.0;  ///< expected over open power; may be NaN
};

/// Octave bands with edges at 0.1 Hz times powers of two that lie completely within `rejection`.
std::vector<RejectionBand> octave_bands(const Spectrum& open, const Spectrum& closed,
                                        const Spectrum& expected);

/// A recording, and the counts of received and lost frames.
struct RecordedLoop {
  ModeSeries recording;
  int received = 0;                ///< frames whose message arrived
  int lost = 0;                    ///< frames without a message
  bool device_clock = true;        ///< times_s are device time stamps; false: arrival times
  std::vector<int> uncorrected_j;  ///< other measured modes, from j = 3 on
  double uncorrected_waves = 0.0;  ///< their RMS, root sum square
  double fit_residual_px = 0.0;    ///< RMS of the displacements that no measured mode explains
  std::string why_not_valid;       ///< reason of the last unusable frame; empty: none
};

/// What the loop left with one control law.
struct MeasuredLaw {
  LoopSettings settings;
  nlohmann::json loop;  ///< result of loop.get with the loop closed
  RecordedLoop closed;
  LoopTiming timing;  ///< measured during the recording
};

struct RejectionMeasured {
  std::vector<int> modes_j;  ///< modes of all recordings
  RecordedLoop open;
  std::vector<MeasuredLaw> laws;
  std::shared_ptr<const LoopModel> model;  ///< null: only an integrator was measured
  double segment_s = 0.0;                  ///< segment length of the spectra
};

struct FoundLaw {
  std::string name;
  LoopTiming timing;
  double noise_passed_waves = 0.0;  ///< RMS noise that the law passes on to the correction
  double noise_limit_waves = 0.0;   ///< RMS residual that the noise of the frames alone would cause
  Spectrum closed, expected;
  std::vector<RejectionPoint> rejection, expected_rejection;
  std::vector<RejectionBand> bands;
};

struct RejectionFound {
  Spectrum open;
  double noise_per_hz = 0.0;   ///< noise floor of `open`, wave^2/Hz
  double noise_waves = 0.0;    ///< RMS noise of one frame, root sum square of the modes
  std::vector<FoundLaw> laws;  ///< as measured
};

RejectionFound find_rejection(const RejectionMeasured& measured);

/// The figures "rejection-spectra" and "rejection".
std::vector<Figure> rejection_figures(const RejectionFound& found);

/// JSON summary; unknown numbers are null.
nlohmann::json rejection_summary(const RejectionMeasured& measured, const RejectionFound& found);

/// Formats a result of rejection_summary as text.
std::string rejection_text(const nlohmann::json& summary);

}  // namespace ovws::study
