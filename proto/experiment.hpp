/// `experiment.*`: the paper's comparison of sensors against the camera's gain, asked for and told.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// One way to measure.
struct SweepArm {
  int charge = 1;
  TrackerKind tracker = TrackerKind::lg;
  /// The paper's Shack-Hartmann sensor, "cell_centroid": the centroid of a fixed cell around the
  /// reference; `tracker` is then `centroid`, and only finds the cells.
  bool fixed_cell = false;
  friend bool operator==(const SweepArm&, const SweepArm&) = default;
};

/// `experiment.gain_sweep`; the defaults are the paper's experiment. A cell is one arm with one
/// aberration at one gain; cells are numbered from 0, arms change fastest, aberrations slowest.
struct GainSweep {
  std::vector<double> gains_db{10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40};
  int frames = 100;  ///< of each cell
  double reference_gain_db = 16.0;
  int reference_frames = 100;
  std::vector<std::vector<Mode>> aberrations;  ///< RMS-normalised waves
  std::vector<SweepArm> arms{{1, TrackerKind::lg},
                             {1, TrackerKind::matched},
                             {0, TrackerKind::centroid, true},
                             {0, TrackerKind::matched}};
  std::vector<double> picture_gains_db{10, 20, 30};  ///< where a frame of each charge is kept
  bool clamp = false;                                ///< gains that the camera has not are left out
  bool anew = false;  ///< cells that are known already are measured again

  struct Cell {
    std::size_t arm, aberration, gain;
  };
  /// Strict; errors as of every decoder. `aberrations` are each as the params of aberration.set.
  static Result<GainSweep> decode(const nlohmann::json& params);
  std::size_t cells() const { return arms.size() * aberrations.size() * gains_db.size(); }
  Cell cell(std::size_t number) const;
};

const std::vector<std::string>& sweep_tracker_names();  ///< tracker_names, and cell_centroid
std::string sweep_tracker_name(const SweepArm& arm);
nlohmann::json to_json(const SweepArm& arm);
/// What GainSweep::decode makes the same sweep of; without `clamp` and `anew`.
nlohmann::json to_json(const GainSweep& sweep);

/// Medians over all spots found in all frames, camera units; NaN: none was found.
struct SpotLevels {
  double level_dn = 0.0;  ///< see SpotFix
  double noise_dn = 0.0;
  double peak_dn = 0.0;  ///< the brightest pixel of all, no median
};

struct ReferenceMeasured {
  int arm = 0;
  double gain_db = 0.0;  ///< as read back
  std::int64_t t_begun_ns = 0;
  int frames = 0, saturated_frames = 0;
  SpotLevels levels;
  std::vector<Vec2> positions_px;  ///< NaN: not used
  std::vector<Vec2> cells_px;      ///< centres; empty: no fixed cells
};
nlohmann::json to_json(const GainSweep& sweep, const ReferenceMeasured& reference);
/// Places of such an object, "positions_px" or "cells_px"; none if it is not one of `arm`.
std::optional<std::vector<Vec2>> reference_places(const nlohmann::json& reference, int arm,
                                                  const char* key = "positions_px");

struct CellMeasured {
  int cell = 0;
  double gain_db = 0.0;  ///< as read back
  double exposure_us = 0.0, frame_rate_hz = 0.0;
  std::int64_t t_begun_ns = 0;
  int subapertures = 0;
  std::vector<int> modes_j;
  struct Frame {
    std::vector<double> coefficients;  ///< RMS-normalised waves; empty: too few spots
    double variance_rad2 = 0.0;        ///< NaN then
    double saturated_fraction = 0.0;   ///< of the spots
    int tracked = 0;
  };
  std::vector<Frame> frames;
  SpotLevels levels;
  struct Picture {  ///< a frame
    int width = 0, height = 0;
    std::string base64;  ///< of its 8 bit pixels, row by row; 255: the format's full scale
  };
  std::optional<Picture> picture;
};
/// `experiment.cell`.
nlohmann::json to_json(const GainSweep& sweep, const CellMeasured& cell);

/// `experiment.get`.
struct ExperimentReport {
  std::string run;  ///< its name, 16 hexadecimal digits
  const GainSweep& request;
  const nlohmann::json& bench;
  std::int64_t t_begun_ns = 0;
  std::optional<int> job;             ///< that measures it now
  std::optional<double> time_left_s;  ///< not known before a cell was measured
  std::optional<std::string> not_kept_reason;
  const std::vector<nlohmann::json>& references;  ///< one an arm, null: not measured yet
  const std::vector<nlohmann::json>& cells;       ///< the same, as experiment.cell
};
nlohmann::json experiment_result(const ExperimentReport* report);

}  // namespace ovws
