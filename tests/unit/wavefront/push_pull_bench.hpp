/// A simulated bench without optics: spots move by a matrix that a test may make wrong.
#pragma once

#include <Eigen/Dense>
#include <numeric>
#include <random>
#include <vector>

#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/spot.hpp"
#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {

struct PushPullBench {
  SensorConfig sensor;
  Lattice lattice = make_lattice(sensor, {}).value();
  std::vector<int> modes_j = std::vector<int>(18);
  double amplitude_waves = 0.1;
  double noise_px = 0.0;  ///< RMS of every mean position
  Eigen::MatrixXd model;  ///< camera pixels per RMS-normalised wave
  Eigen::MatrixXd truth;  ///< the matrix that the bench follows
  std::vector<Vec2> rest_px;
  std::mt19937 random{20260117};

  PushPullBench() {
    std::iota(modes_j.begin(), modes_j.end(), 1);
    model = slope_matrix(lattice, sensor, modes_j, tilt_radius(sensor.charge, {}),
                         px_per_cycle({}, {}));
    truth = model;
    rest_px = model_spots_px(lattice, sensor, {}, {}, 512, 512);
  }

  SpotMeans means(std::size_t k, double waves) {
    std::normal_distribution<double> noise(0.0, 1.0);
    SpotMeans means;
    for (std::size_t i = 0; i < rest_px.size(); ++i) {
      const auto row = 2 * Eigen::Index(i), col = Eigen::Index(k);
      const Vec2 moved{waves * truth(row, col) + noise_px * noise(random),
                       waves * truth(row + 1, col) + noise_px * noise(random)};
      means.at_px.push_back(rest_px[i] + moved);
      means.standard_error_px.push_back({noise_px, noise_px});
    }
    return means;
  }

  PushPullRun run() {
    PushPullRun run{means(0, 0.0), means(0, 0.0), {}};
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      run.modes.push_back(
          {modes_j[k], amplitude_waves, means(k, amplitude_waves), means(k, -amplitude_waves)});
    }
    return run;
  }

  /// One frame, without noise.
  std::vector<SpotFix> shown(Mode mode) const {
    std::vector<SpotFix> spots;
    for (std::size_t i = 0; i < rest_px.size(); ++i) {
      SpotFix fix;
      const auto row = 2 * Eigen::Index(i), col = Eigen::Index(mode.j - 1);
      fix.x = float(rest_px[i].x + mode.waves * truth(row, col));
      fix.y = float(rest_px[i].y + mode.waves * truth(row + 1, col));
      spots.push_back(fix);
    }
    return spots;
  }
};

}  // namespace ovws
