/// The paper's gain sweep, which compares sensors by their residual phase variance over the
/// camera's gain: params of `ovws study experiment`, what it measures, and its report.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/params.hpp"

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

/// Intensity levels over all spots found in all frames, in camera grey levels (DN). NaN if no spot
/// was found.
struct SpotLevels {
  double level_dn = 0.0;  ///< median of SpotFix::level: mean above the background
  double noise_dn = 0.0;  ///< median of SpotFix::noise, RMS
  double peak_dn = 0.0;   ///< maximum of SpotFix::peak
};

struct ReferenceMeasured {
  int arm = 0;
  SweepArm with;
  double gain_db = 0.0;  ///< as read back from the camera
  std::int64_t t_begun_ns = 0;
  int frames = 0, saturated_frames = 0;
  SpotLevels levels;
  std::vector<Vec2> positions_px;  ///< camera pixels of the region; NaN: spot not used
  std::vector<Vec2> cells_px;      ///< centres of the fixed windows; empty: none
};

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

/// The reference as JSON; its keys are those of the struct.
Json report_of(const ReferenceMeasured& reference);

/// The cell as JSON: its keys are those of the struct, with the charge and the tracker of its arm,
/// and over its frames, rad^2:
///
///     variance_rad2               residual phase variance, mean: 4 pi^2 times the sum of the
///     squares
///                                 of the measured minus the introduced coefficients
///                                 (RMS-normalised waves, tilts included)
///     standard_deviation_rad2, standard_error_rad2   of single frames; of the mean
///     unsaturated_variance_rad2   mean over the frames without a saturated spot
///     undetermined_frames         with too few spots to determine the modes; not in the mean
///     saturated_frames            with a saturated spot
///     lost_spots                  over all frames
///
/// and lists over its frames: variances_rad2, coefficients_waves (of modes_j, rounded to 1e-6),
/// saturated_fractions, tracked. Null: there is no such value.
Json report_of(const CellMeasured& cell);
/// The same without the lists over its frames.
Json summary_of(Json cell_report);

}  // namespace ovws

namespace ovws::study {

/// The cells of a whole sweep by number, by report_of.
using SweepCells = std::map<int, nlohmann::json>;

/// CSV files of cells; column names contain the units.
std::string cells_csv_header();
std::string cells_csv_row(const nlohmann::json& cell);
std::string frames_csv_header(const nlohmann::json& cell);  ///< last columns: the cell's modes
std::string frames_csv_rows(const nlohmann::json& cell);

/// Name of an arm of the gain sweep, e.g. "charge 1, lg".
std::string arm_name(const SweepArm& arm);

/// Table of residual variances: one row per gain, one column per arm.
std::string sweep_table(const GainSweep& sweep, const SweepCells& cells);
/// Figures of the residual variances, one per aberration.
std::vector<Figure> sweep_figures(const GainSweep& sweep, const SweepCells& cells);
/// Compares each pair of arms: `cells` that both arms measured, and in how many of them the first
/// arm's variance is `lower`.
nlohmann::json sweep_comparisons(const GainSweep& sweep, const SweepCells& cells);

}  // namespace ovws::study
