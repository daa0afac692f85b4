/// Field tables of `experiment.*`: the paper's gain sweep, which compares sensors by their residual
/// phase variance over the camera's gain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"
#include "proto/tables/modes.hpp"
#include "proto/tables/origin.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// Tracker of one arm. With `fixed_cell` ("cell_centroid" on the wire) it is the paper's
/// Shack-Hartmann sensor: the centroid of a fixed window around the reference position, which
/// `centroid` measured.
struct SweepTracker {
  TrackerKind kind = TrackerKind::lg;
  bool fixed_cell = false;
  friend bool operator==(const SweepTracker&, const SweepTracker&) = default;
};
const std::vector<std::string>& sweep_tracker_names();  ///< tracker_names() and "cell_centroid"
template <>
struct Wire<SweepTracker> {
  static Json to_json(const SweepTracker& tracker);
  static void decode(ObjectReader& reader, const FieldInfo& field, SweepTracker& out);
  static Json schema(SchemaParts&, const FieldInfo&) {
    return {{"type", "string"}, {"enum", sweep_tracker_names()}};
  }
};

/// One sensor of the comparison: a topological charge and a tracker.
struct SweepArm {
  int charge = 1;
  SweepTracker tracker;
  friend bool operator==(const SweepArm&, const SweepArm&) = default;
};
template <>
struct Table<SweepArm> {
  static constexpr const char* kName = "SweepArm";
  static constexpr auto kFields = Fields{
      field("charge", &SweepArm::charge, "topological charge; 0: the Shack-Hartmann sensor",
            limits::kCharge)
          .mandatory(),
      field(
          "tracker", &SweepArm::tracker,
          "tracker as in sensor.set, or cell_centroid: the centroid of all intensity in a fixed "
          "window around the reference, as in the textbook Shack-Hartmann sensor and in the paper")
          .mandatory()};
};

/// Oblique astigmatism of 0.5, 1.5 and 2 waves at the pupil's edge, as in the paper; returned
/// RMS-normalised.
std::vector<ModesSet> paper_aberrations();

/// Params of `experiment.gain_sweep`; the defaults are the paper's experiment. A cell is one arm
/// with one aberration at one gain. Cells are numbered from 0: arms change fastest, then gains,
/// aberrations slowest.
struct GainSweep {
  std::vector<double> gains_db{10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40};
  int frames = 100;  ///< settled frames of each cell
  double reference_gain_db = 16.0;
  int reference_frames = 100;
  std::vector<ModesSet> aberrations = paper_aberrations();
  std::vector<SweepArm> arms{{1, {TrackerKind::lg}},
                             {1, {TrackerKind::matched}},
                             {0, {TrackerKind::centroid, true}},
                             {0, {TrackerKind::matched}}};
  std::vector<double> picture_gains_db{10, 20,
                                       30};  ///< gains at which one image per charge is stored

  struct Cell {
    std::size_t arm, aberration, gain;
  };
  std::size_t cells() const { return arms.size() * aberrations.size() * gains_db.size(); }
  Cell cell(std::size_t number) const;
};
template <>
struct Table<GainSweep> {
  static constexpr const char* kName = "GainSweep";
  static constexpr auto kFields = Fields{
      field("gains_db", &GainSweep::gains_db, "camera gains of the cells in their order, dB",
            limits::kGainDb)
          .sized(1, limits::kSweepGains)
          .unlike(),
      field("frames", &GainSweep::frames, "number of settled frames of each cell",
            limits::kSweepFrames),
      field("reference_gain_db", &GainSweep::reference_gain_db,
            "gain at which the references are taken, dB", limits::kGainDb),
      field("reference_frames", &GainSweep::reference_frames,
            "number of settled frames of each reference", limits::kSweepFrames),
      field("aberrations", &GainSweep::aberrations,
            "aberrations to introduce, each as the params of aberration.set; default: oblique "
            "astigmatism of 0.5, 1.5 and 2 waves at the pupil's edge, as in the paper")
          .sized(1, limits::kSweepAberrations),
      field("arms", &GainSweep::arms,
            "sensors to compare; default: charge 1 with lg and matched, charge 0 with "
            "cell_centroid and matched")
          .sized(1, limits::kSweepArms)
          .unlike(),
      field("picture_gains_db", &GainSweep::picture_gains_db,
            "gains at which one image per charge is stored, with the first aberration, dB",
            limits::kGainDb)
          .sized(0, limits::kSweepPictures)
          .unlike()};
};

struct GainSweepRun {
  GainSweep sweep;
  bool clamp = false;  ///< skip gains that the camera does not support
  bool anew = false;   ///< discard stored cells and measure them again
};
template <>
struct Table<GainSweepRun> {
  static constexpr const char* kName = "GainSweepRun";
  static constexpr auto kFields =
      Fields{inlined(&GainSweepRun::sweep),
             field("clamp", &GainSweepRun::clamp,
                   "true: gains that the camera does not support are skipped instead of refused"),
             field("anew", &GainSweepRun::anew,
                   "true: the stored cells of this run are discarded and measured again")};
};

/// Rounds to 1e-6, which keeps the numbers in files short and is far below any noise.
double to_millionth(double value);

/// Levels over all spots found in all frames, in camera grey levels (DN); NaN: no spot was found.
struct SpotLevels {
  double level_dn = 0.0;  ///< median of SpotFix::level
  double noise_dn = 0.0;  ///< median of SpotFix::noise
  double peak_dn = 0.0;   ///< maximum of SpotFix::peak
};
template <>
struct Table<SpotLevels> {
  using L = SpotLevels;
  static constexpr const char* kName = "SpotLevels";
  static constexpr auto kFields =
      Fields{computed<L>(
                 "level_dn", [](const L& levels) { return to_millionth(levels.level_dn); },
                 "mean level of a spot's bright part above its background, median over spots "
                 "and frames, DN; null: no spot was found")
                 .or_null(),
             computed<L>(
                 "noise_dn", [](const L& levels) { return to_millionth(levels.noise_dn); },
                 "RMS pixel noise around a spot, median over spots and frames, DN; null: no "
                 "spot was found")
                 .or_null(),
             computed<L>(
                 "peak_dn", [](const L& levels) { return to_millionth(levels.peak_dn); },
                 "brightest pixel of any spot, DN; null: no spot was found")
                 .or_null()};
};

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
struct Table<ReferenceMeasured> {
  using R = ReferenceMeasured;
  static constexpr const char* kName = "SweepReference";
  static constexpr auto kFields =
      Fields{field("arm", &R::arm, "index in the request's arms", Bounds::at_least(0)),
             inlined(&R::with),
             field("gain_db", &R::gain_db, "gain as read back from the camera, dB"),
             field("t_begun_ns", &R::t_begun_ns, kTimeMeaning),
             field("frames", &R::frames, "number of averaged frames", Bounds::at_least(2)),
             field("saturated_frames", &R::saturated_frames,
                   "number of frames with a saturated spot", Bounds::at_least(0)),
             inlined(&R::levels),
             field("positions_px", &R::positions_px,
                   "[x, y] of each spot, camera pixels of the region of interest; null: the "
                   "spot is not used")
                 .with_nulls(),
             field("cells_px", &R::cells_px,
                   "[x, y] of each fixed window's centre, camera pixels of the region of "
                   "interest; empty: the tracker is not cell_centroid")
                 .with_nulls()};
};
/// Reads "positions_px" or "cells_px" from the JSON of a ReferenceMeasured; none if it is malformed
/// or belongs to another arm.
std::optional<std::vector<Vec2>> reference_places(const Json& reference, int arm,
                                                  const char* key = "positions_px");

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
  struct Picture {  ///< one camera image
    int width = 0, height = 0;
    std::string base64;  ///< 8-bit pixels, row by row; 255: the format's full scale
  };
  std::optional<Picture> picture;
};
template <>
struct Table<CellMeasured::Picture> {
  using P = CellMeasured::Picture;
  static constexpr const char* kName = "CellPicture";
  static constexpr auto kFields =
      Fields{field("width", &P::width, "width, pixels", Bounds::at_least(1)),
             field("height", &P::height, "height, pixels", Bounds::at_least(1)),
             field("base64", &P::base64,
                   "8-bit grey levels in base64, row by row; 255: the format's full scale")};
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
struct Table<CellVariance> {
  using V = CellVariance;
  static constexpr const char* kName = "CellVariance";
  static constexpr auto kFields = Fields{
      field("variance_rad2", &V::mean,
            "residual phase variance, mean over the frames, rad^2: 4 pi^2 times the sum of the "
            "squares of the measured minus the introduced coefficients (RMS-normalised waves, "
            "tilts included); null: no frame had enough spots")
          .or_null(),
      field("standard_deviation_rad2", &V::standard_deviation,
            "standard deviation of single frames, rad^2")
          .or_null(),
      field("standard_error_rad2", &V::standard_error, "standard error of the mean, rad^2")
          .or_null(),
      field("unsaturated_variance_rad2", &V::unsaturated,
            "mean over the frames without a saturated spot, rad^2; null: there is no such frame")
          .or_null(),
      field("undetermined_frames", &V::undetermined_frames,
            "number of frames with too few spots to determine the modes; they are not in the mean",
            Bounds::at_least(0)),
      field("saturated_frames", &V::saturated_frames, "number of frames with a saturated spot",
            Bounds::at_least(0)),
      field("lost_spots", &V::lost_spots, "number of lost spots over all frames",
            Bounds::at_least(0))};
};

/// Results of a cell without the values of single frames.
struct CellSummary {
  CellMeasured cell;
  CellVariance variance;
  SpotLevels levels;

  CellSummary() = default;
  explicit CellSummary(CellMeasured measured);
};
template <>
struct Table<CellSummary> {
  using S = CellSummary;
  static constexpr const char* kName = "CellSummary";
  static constexpr auto kFields = Fields{
      computed<S>(
          "cell", [](const S& s) { return s.cell.cell; },
          "number of the cell, from 0: arms change fastest, then gains, aberrations slowest",
          limits::kSweepCell),
      computed<S>(
          "arm", [](const S& s) { return s.cell.at.arm; }, "index in the request's arms"),
      computed<S>(
          "charge", [](const S& s) { return s.cell.with.charge; },
          "topological charge; 0: the Shack-Hartmann sensor", limits::kCharge),
      computed<S>(
          "tracker", [](const S& s) { return s.cell.with.tracker; },
          "tracker, as in experiment.gain_sweep"),
      computed<S>(
          "aberration", [](const S& s) { return s.cell.at.aberration; },
          "index in the request's aberrations"),
      computed<S>(
          "gain_db", [](const S& s) { return s.cell.gain_db; },
          "gain as read back from the camera, dB"),
      computed<S>(
          "exposure_us", [](const S& s) { return s.cell.exposure_us; },
          "exposure time, microseconds"),
      computed<S>(
          "frame_rate_hz", [](const S& s) { return s.cell.frame_rate_hz; }, "frames per second"),
      computed<S>(
          "t_begun_ns", [](const S& s) { return s.cell.t_begun_ns; }, kTimeMeaning),
      computed<S>(
          "frames", [](const S& s) { return s.cell.frames.size(); },
          "number of settled frames, all of which count"),
      inlined(&S::variance),
      inlined(&S::levels)};
};

/// Result of `experiment.cell`.
struct CellReport {
  CellSummary summary;

  /// get(frame) of all frames, in order.
  template <class Get>
  auto of_frames(Get get) const {
    std::vector<decltype(get(CellMeasured::Frame()))> all;
    for (const CellMeasured::Frame& frame : summary.cell.frames) all.push_back(get(frame));
    return all;
  }
};
template <>
struct Table<CellReport> {
  using C = CellReport;
  using F = CellMeasured::Frame;
  static constexpr const char* kName = "CellReport";
  static constexpr auto kFields = Fields{
      inlined(&C::summary),
      computed<C>(
          "modes_j", [](const C& c) { return c.summary.cell.modes_j; },
          "OSA/ANSI indices of the modes, in the order of coefficients_waves"),
      computed<C>(
          "variances_rad2",
          [](const C& c) { return c.of_frames([](const F& f) { return f.variance_rad2; }); },
          "residual phase variance of each frame, rad^2; null: too few spots")
          .with_nulls(),
      computed<C>(
          "coefficients_waves",
          [](const C& c) {
            return c.of_frames([](const F& f) {
              std::vector<double> waves;
              for (const double one : f.coefficients) waves.push_back(to_millionth(one));
              return waves;
            });
          },
          "coefficients of each frame minus the reference, RMS-normalised waves, rounded to 1e-6; "
          "empty: too few spots")
          .with_nulls(),
      computed<C>("saturated_fractions",
                  [](const C& c) {
                    return c.of_frames(
                        [](const F& f) { return to_millionth(f.saturated_fraction); });
                  },
                  "fraction of spots with a saturated pixel in each frame", {0, 1}),
      computed<C>(
          "tracked", [](const C& c) { return c.of_frames([](const F& f) { return f.tracked; }); },
          "number of spots found in each frame", Bounds::at_least(0)),
      computed<C>(
          "picture", [](const C& c) { return c.summary.cell.picture; },
          "an image of the cell, if one was stored")};
};

struct ExperimentReport {
  std::string run;  ///< name of the run, 16 hexadecimal digits
  GainSweep request;
  JsonOf<SweepBench> bench;
  std::int64_t t_begun_ns = 0;
  std::optional<int> job;             ///< job that measures it now
  std::optional<double> time_left_s;  ///< empty until a cell has been measured
  std::optional<std::string> not_kept_reason;
  std::vector<JsonOf<ReferenceMeasured>> references;
  std::vector<JsonOf<CellSummary>> cells;
};
template <>
struct Table<ExperimentReport> {
  using R = ExperimentReport;
  static constexpr const char* kName = "ExperimentReport";
  static constexpr auto kFields = Fields{
      field("run", &R::run,
            "name of the run, 16 hexadecimal digits: the same for the same request on the same "
            "bench"),
      field("job", &R::job, "job that measures it now; null: none"),
      field("t_begun_ns", &R::t_begun_ns, "time of the first request, UNIX epoch UTC, nanoseconds"),
      time_text("t_begun", &R::t_begun_ns),
      field("time_left_s", &R::time_left_s,
            "estimated remaining time, seconds, by the cells that its job has measured; null: none "
            "yet, or no job",
            Bounds::at_least(0)),
      field("not_kept_reason", &R::not_kept_reason,
            "why cells are not stored and would be lost by a restart; null: all are stored"),
      field("request", &R::request,
            "the complete params; aberrations are RMS-normalised, skipped gains are not included"),
      field("bench", &R::bench, "bench and settings of the measurement"),
      field("references", &R::references, "references taken so far, one per arm"),
      field("cells", &R::cells, "cells measured so far, ordered by number")};
};

/// Result of `experiment.get`.
struct KnownExperiment {
  std::optional<ExperimentReport> experiment;
  std::size_t cells_total = 0;

  std::size_t cells_done() const { return experiment ? experiment->cells.size() : 0; }
};
template <>
struct Table<KnownExperiment> {
  using K = KnownExperiment;
  static constexpr const char* kName = "KnownExperiment";
  static constexpr auto kFields = Fields{
      computed<K>(
          "known", [](const K& k) { return k.experiment.has_value(); }, "whether there is a run"),
      computed<K>(
          "complete", [](const K& k) { return k.experiment && k.cells_done() == k.cells_total; },
          "whether every cell has been measured"),
      field("cells_total", &K::cells_total, "number of cells of the request"),
      computed<K>(
          "cells_done", [](const K& k) { return k.cells_done(); }, "number of measured cells"),
      inlined(&K::experiment)};
};

}  // namespace ovws
