/// Calibrations that a client has measured with a corrector of its own (calibration.set).
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"

namespace ovws {
namespace {

Result<void> check_modes(const std::vector<int>& given_j, const std::vector<int>& determined_j) {
  for (std::size_t k = 0; k < given_j.size(); ++k) {
    const int j = given_j[k];
    if (k > 0 && given_j[k - 1] >= j) {
      return fail(Errc::invalid, "modes", "must be in ascending order, as the columns");
    }
    if (std::find(determined_j.begin(), determined_j.end(), j) != determined_j.end()) continue;
    return fail(Errc::invalid, "modes",
                fmt::format("this lattice does not determine j = {}, only j = 1 to {}", j,
                            determined_j.empty() ? 0 : determined_j.back()));
  }
  return {};
}

Result<void> check_given_sizes(const CalibrationSet& given, int subapertures, std::size_t bytes) {
  const std::vector<int> due{2, 2 * subapertures, int(given.modes_j.size())};
  if (given.shape != due) {
    return fail(Errc::invalid, "shape",
                fmt::format("is [{}], but the sensor has {} subapertures, and {} modes are given: "
                            "must be [{}]",
                            fmt::join(given.shape, ", "), subapertures, given.modes_j.size(),
                            fmt::join(due, ", ")));
  }
  const std::size_t due_bytes =
      sizeof(float) * 2 * 2 * std::size_t(subapertures) * given.modes_j.size();
  if (bytes == due_bytes) return {};
  return fail(Errc::invalid, "matrix",
              fmt::format("the binary frame after the JSON has {} bytes, but shape needs {}: send "
                          "the matrix and its standard errors as float32",
                          bytes, due_bytes));
}

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Result<InteractionMatrix> matrix_of(const CalibrationSet& given, const std::string& bytes) {
  RowMajor both(2 * given.shape[1], given.shape[2]);
  std::memcpy(both.data(), bytes.data(), bytes.size());
  const Eigen::MatrixXf slopes = both.topRows(given.shape[1]);
  const Eigen::MatrixXf errors = both.bottomRows(given.shape[1]);
  constexpr float kMaxPxPerWave = 1e6F;
  if (!both.allFinite() || errors.minCoeff() < 0.0F || both.cwiseAbs().maxCoeff() > kMaxPxPerWave) {
    return fail(
        Errc::invalid, "matrix",
        "must hold numbers from -1e6 to 1e6 px per wave, and standard errors of 0 and more: "
        "give a lost spot rows of 0");
  }
  return interaction_matrix(given.modes_j, given.amplitude_waves, slopes, errors);
}

}  // namespace

SensorChange give_calibration(CalibrationSet given, std::string bytes) {
  return [given = std::move(given), bytes = std::move(bytes)](SensorEdit& edit) -> Result<void> {
    const SensorState& state = edit.state;
    const BenchOptics& optics = edit.bench.optics;
    if (state.tracking.tracker == TrackerKind::fit) {
      return fail(Errc::refused, "tracker",
                  "the tracker fit measures all pixels of the spots, and displacements do not "
                  "calibrate these: choose a tracker of positions with sensor.set, such as lg");
    }
    const ModeOperator model =
        slope_operator(state.renderer->lattice(), state.sensor, state.tracking,
                       px_per_cycle(optics_of(state, optics), optics.slm));
    if (auto good = check_modes(given.modes_j, model.modes_j); !good) return good;
    if (auto good = check_given_sizes(given, int(model.slopes.rows() / 2), bytes.size()); !good) {
      return good;
    }
    auto matrix = matrix_of(given, bytes);
    if (!matrix) return fail(matrix.error());
    MeasuredCalibration calibration;
    calibration.amplitude_waves = given.amplitude_waves;
    calibration.frames = given.frames;
    calibration.t_taken_ns = utc_ns();
    calibration.comparison = compare(*matrix, model);
    calibration.matrix = std::move(*matrix);
    return use_calibration(state.sensor_epoch, std::move(calibration))(edit);
  };
}

}  // namespace ovws
