/// The paper's gain sweep, which compares sensors by their residual phase variance over the
/// camera's gain: params of `ovws study experiment`, and what it measures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// Tracker of one arm of the gain sweep. `fixed_cell` (named "cell_centroid") selects the
/// paper's Shack-Hartmann sensor: the centroid of a fixed window around the reference position. The
/// tracker `centroid` measured that position.
struct SweepTracker {
  TrackerKind kind = TrackerKind::lg;
  bool fixed_cell = false;
  friend bool operator==(const SweepTracker&, const SweepTracker&) = default;
};
const std::vector<std::string>&
sweep_tracker_names();  ///< names of TrackerKind, then "cell_centroid"
template <>
struct Wire<SweepTracker> {
  static Json to_json(const SweepTracker& tracker);
  static void decode(ObjectReader& reader, const FieldInfo& field, SweepTracker& out);
  static Json schema(SchemaParts&, const FieldInfo&) {
    return {{"type", "string"}, {"enum", sweep_tracker_names()}};
  }
};

/// Arm (one sensor) of the gain sweep: a topological charge and a tracker.
struct SweepArm {
  int charge = 1;
  SweepTracker tracker;
  friend bool operator==(const SweepArm&, const SweepArm&) = default;
};
template <>
inline constexpr auto kTable<SweepArm> = Fields{
    "SweepArm",
    field<&SweepArm::charge>("topological charge; 0: the Shack-Hartmann sensor", limits::kCharge)
        .mandatory(),
    field<&SweepArm::tracker>(
        "tracker as in sensor.set, or cell_centroid: the centroid of all intensity in a fixed "
        "window around the reference, as in the textbook Shack-Hartmann sensor and in the paper")
        .mandatory()};

/// Oblique astigmatism of 0.5, 1.5 and 2 waves at the pupil's edge, as in the paper; returned
/// RMS-normalised.
std::vector<ModesSet> paper_aberrations();

/// Params; the defaults are the paper's experiment. A cell is one arm with one aberration at one
/// gain. Cells are numbered from 0: arms change fastest, then gains, aberrations slowest.
struct GainSweep {
  std::vector<double> gains_db{10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40};
  int frames = 100;  ///< settled frames of each cell
  double reference_gain_db = 16.0;
  int reference_frames = 100;
  std::vector<ModesSet> aberrations = paper_aberrations();
  std::vector<SweepArm> arms{{1, {TrackerKind::lg}},
                             {1, {TrackerKind::fit}},
                             {0, {TrackerKind::centroid, true}},
                             {0, {TrackerKind::fit}}};
  std::vector<double> picture_gains_db{10, 20,
                                       30};  ///< gains at which one image per charge is drawn
  bool clamp = false;                        ///< skip gains that the camera does not support

  struct Cell {
    std::size_t arm, aberration, gain;
  };
  std::size_t cells() const { return arms.size() * aberrations.size() * gains_db.size(); }
  Cell cell(std::size_t number) const;
};
template <>
inline constexpr auto kTable<GainSweep> = Fields{
    "GainSweep",
    field<&GainSweep::gains_db>("camera gains of the cells in their order, dB", limits::kGainDb)
        .sized(1, limits::kSweepGains)
        .unlike(),
    field<&GainSweep::frames>("number of settled frames of each cell", limits::kSweepFrames),
    field<&GainSweep::reference_gain_db>("gain at which the references are taken, dB",
                                         limits::kGainDb),
    field<&GainSweep::reference_frames>("number of settled frames of each reference",
                                        limits::kSweepFrames),
    field<&GainSweep::aberrations>(
        "aberrations to introduce, each as the params of aberration.set; default: oblique "
        "astigmatism of 0.5, 1.5 and 2 waves at the pupil's edge, as in the paper")
        .sized(1, limits::kSweepAberrations),
    field<&GainSweep::arms>("sensors to compare; default: charge 1 with lg and fit, charge 0 with "
                            "cell_centroid and fit")
        .sized(1, limits::kSweepArms)
        .unlike(),
    field<&GainSweep::picture_gains_db>(
        "gains at which one image per charge is drawn, with the first aberration, dB",
        limits::kGainDb)
        .sized(0, limits::kSweepImages)
        .unlike(),
    field<&GainSweep::clamp>(
        "true: gains that the camera does not support are skipped instead of refused")};

/// Rounds to 1e-6, which keeps the numbers in files short and is far below any noise.
double to_millionth(double value);

/// Intensity levels over all spots found in all frames, in camera grey levels (DN). NaN if no spot
/// was found.
struct SpotLevels {
  double level_dn = 0.0;  ///< median of SpotFix::level
  double noise_dn = 0.0;  ///< median of SpotFix::noise
  double peak_dn = 0.0;   ///< maximum of SpotFix::peak
};
template <>
inline constexpr auto kTable<SpotLevels> = Fields{
    "SpotLevels",
    computed(
        "level_dn", [](auto& levels) { return to_millionth(levels.level_dn); },
        "mean level of a spot's bright part above its background, median over spots and frames, "
        "DN; null: no spot was found")
        .or_null(),
    computed(
        "noise_dn", [](auto& levels) { return to_millionth(levels.noise_dn); },
        "RMS pixel noise around a spot, median over spots and frames, DN; null: no spot was found")
        .or_null(),
    computed(
        "peak_dn", [](auto& levels) { return to_millionth(levels.peak_dn); },
        "brightest pixel of any spot, DN; null: no spot was found")
        .or_null()};

struct ReferenceMeasured {
  int arm = 0;
  SweepArm with;
  double gain_db = 0.0;  ///< as read back from the camera
  std::int64_t t_begun_ns = 0;
  int frames = 0, saturated_frames = 0;
  SpotLevels levels;
  std::vector<Vec2> positions_px;  ///< NaN: spot not used
  std::vector<Vec2> cells_px;      ///< centres of the fixed windows; empty: none
};
template <>
inline constexpr auto kTable<ReferenceMeasured> = Fields{
    "SweepReference",
    field<&ReferenceMeasured::arm>("index in the request's arms", Bounds::at_least(0)),
    inlined(&ReferenceMeasured::with),
    field<&ReferenceMeasured::gain_db>("gain as read back from the camera, dB"),
    field<&ReferenceMeasured::t_begun_ns>(kTimeMeaning),
    field<&ReferenceMeasured::frames>("number of averaged frames", Bounds::at_least(2)),
    field<&ReferenceMeasured::saturated_frames>("number of frames with a saturated spot",
                                                Bounds::at_least(0)),
    inlined(&ReferenceMeasured::levels),
    field<&ReferenceMeasured::positions_px>(
        "[x, y] of each spot, camera pixels of the region of interest; null: the spot is not used")
        .with_nulls(),
    field<&ReferenceMeasured::cells_px>(
        "[x, y] of each fixed window's centre, camera pixels of the region of interest; empty: the "
        "tracker is not cell_centroid")
        .with_nulls()};

struct CellMeasured {
  int cell = 0;
  GainSweep::Cell at{};
  SweepArm with;
  double gain_db = 0.0;  ///< as read back from the camera
  double exposure_us = 0.0, frame_rate_hz = 0.0;
  std::int64_t t_begun_ns = 0;
  int subapertures = 0;
  std::vector<int> modes_j;
  struct Frame {
    std::vector<double> coefficients;  ///< RMS-normalised waves; empty: too few spots
    double variance_rad2 = 0.0;        ///< NaN: too few spots
    double saturated_fraction = 0.0;   ///< fraction of spots with a saturated pixel
    int tracked = 0;
  };
  std::vector<Frame> frames;
  SpotLevels levels;
};

/// Residual phase variance of a cell's frames, rad^2; NaN: no frame had enough spots to determine
/// its modes.
struct CellVariance {
  double mean = 0.0, standard_deviation = 0.0, standard_error = 0.0;
  double unsaturated = 0.0;  ///< mean over frames without a saturated spot
  int undetermined_frames = 0;
  int saturated_frames = 0, lost_spots = 0;
};
template <>
inline constexpr auto kTable<CellVariance> = Fields{
    "CellVariance",
    field("variance_rad2", &CellVariance::mean,
          "residual phase variance, mean over the frames, rad^2: 4 pi^2 times the sum of the "
          "squares of the measured minus the introduced coefficients (RMS-normalised waves, tilts "
          "included); null: no frame had enough spots")
        .or_null(),
    field("standard_deviation_rad2", &CellVariance::standard_deviation,
          "standard deviation of single frames, rad^2")
        .or_null(),
    field("standard_error_rad2", &CellVariance::standard_error, "standard error of the mean, rad^2")
        .or_null(),
    field("unsaturated_variance_rad2", &CellVariance::unsaturated,
          "mean over the frames without a saturated spot, rad^2; null: there is no such frame")
        .or_null(),
    field<&CellVariance::undetermined_frames>(
        "number of frames with too few spots to determine the modes; they are not in the mean",
        Bounds::at_least(0)),
    field<&CellVariance::saturated_frames>("number of frames with a saturated spot",
                                           Bounds::at_least(0)),
    field<&CellVariance::lost_spots>("number of lost spots over all frames", Bounds::at_least(0))};

/// Results of a cell without the values of single frames.
struct CellSummary : CellMeasured {
  CellVariance variance;

  CellSummary() = default;
  explicit CellSummary(CellMeasured measured);
};
template <>
inline constexpr auto kTable<CellSummary> =
    Fields{"CellSummary",
           field<&CellSummary::cell>(
               "number of the cell, from 0: arms change fastest, then gains, aberrations slowest",
               limits::kSweepCell),
           computed(
               "arm", [](auto& s) { return s.at.arm; }, "index in the request's arms"),
           computed(
               "charge", [](auto& s) { return s.with.charge; },
               "topological charge; 0: the Shack-Hartmann sensor", limits::kCharge),
           computed(
               "tracker", [](auto& s) { return s.with.tracker; }, "tracker"),
           computed(
               "aberration", [](auto& s) { return s.at.aberration; },
               "index in the request's aberrations"),
           field<&CellSummary::gain_db>("gain as read back from the camera, dB"),
           field<&CellSummary::exposure_us>("exposure time, microseconds"),
           field<&CellSummary::frame_rate_hz>("frames per second"),
           field<&CellSummary::t_begun_ns>(kTimeMeaning),
           computed(
               "frames", [](auto& s) { return s.frames.size(); },
               "number of settled frames, all of which count"),
           inlined(&CellSummary::variance),
           inlined(&CellSummary::levels)};

/// Results of a cell.
struct CellReport : CellSummary {
  /// Values of get(frame) for all frames of the cell, in order.
  template <class Get>
  auto of_frames(Get get) const {
    std::vector<decltype(get(std::declval<const Frame&>()))> all;
    for (const Frame& frame : frames) all.push_back(get(frame));
    return all;
  }
};
template <>
inline constexpr auto kTable<CellReport> = Fields{
    "CellReport",
    based<CellSummary>(),
    field<&CellReport::modes_j>(
        "OSA/ANSI indices of the modes, in the order of coefficients_waves"),
    computed(
        "variances_rad2",
        [](auto& c) { return c.of_frames([](auto& f) { return f.variance_rad2; }); },
        "residual phase variance of each frame, rad^2; null: too few spots")
        .with_nulls(),
    computed(
        "coefficients_waves",
        [](auto& c) {
          return c.of_frames([](auto& f) {
            std::vector<double> waves;
            for (const double one : f.coefficients) waves.push_back(to_millionth(one));
            return waves;
          });
        },
        "coefficients of each frame, relative to the arm's reference, RMS-normalised waves, "
        "rounded "
        "to 1e-6; an empty list: the frame has too few spots")
        .with_nulls(),
    computed("saturated_fractions",
             [](auto& c) {
               return c.of_frames([](auto& f) { return to_millionth(f.saturated_fraction); });
             },
             "fraction of spots with a saturated pixel in each frame", {0, 1}),
    computed(
        "tracked", [](auto& c) { return c.of_frames([](auto& f) { return f.tracked; }); },
        "number of spots found in each frame", Bounds::at_least(0))};

}  // namespace ovws
