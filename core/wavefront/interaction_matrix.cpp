#include "core/wavefront/interaction_matrix.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/decompositions.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {
namespace {

constexpr double kMaxNoise = 0.1;  // largest noise, share of a column's signal
constexpr std::size_t kMinMatrixSpots = 3;
constexpr double kModelError = 0.2;  // relative error of a displacement taken from the model

bool found(const SpotMeans& spots, std::size_t i) {
  return std::isfinite(spots.at_px[i].x) && std::isfinite(spots.at_px[i].y);
}

/// Factor by which the measured displacements exceed the model's: the least-squares slope of all
/// spots that are found with both signs of the poke; 1 if there are none.
double factor_of(const PushPull& poke, const Eigen::Ref<const Eigen::VectorXd>& model) {
  double both = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < poke.plus.at_px.size(); ++i) {
    if (!found(poke.plus, i) || !found(poke.minus, i)) continue;
    const Vec2 moved = poke.plus.at_px[i] - poke.minus.at_px[i];
    const auto row = 2 * Eigen::Index(i);
    const double x = 2.0 * poke.amplitude_waves * model[row];
    const double y = 2.0 * poke.amplitude_waves * model[row + 1];
    both += moved.x * x + moved.y * y;
    squares += x * x + y * y;
  }
  return squares > 0.0 ? both / squares : 1.0;
}

/// Fills in a spot lost in one image: its position in the other image, mirrored about its resting
/// position.
void mirror(const SpotMeans& seen, const SpotMeans& resting, std::size_t i, SpotMeans& lost) {
  const Vec2 &a = seen.standard_error_px[i], &b = resting.standard_error_px[i];
  lost.at_px[i] = 2.0 * resting.at_px[i] - seen.at_px[i];
  lost.standard_error_px[i] = {std::hypot(a.x, 2.0 * b.x), std::hypot(a.y, 2.0 * b.y)};
}

/// Fills in a spot lost in both images: the model's displacement, with a standard error of a fifth
/// of the displacement.
void follow_model(const SpotMeans& resting, const Eigen::Vector2d& px_per_wave, std::size_t i,
                  PushPull& poke) {
  const Vec2 moved = poke.amplitude_waves * Vec2{px_per_wave.x(), px_per_wave.y()};
  poke.plus.at_px[i] = resting.at_px[i] + moved;
  poke.minus.at_px[i] = resting.at_px[i] - moved;
  const double error_px = kModelError * norm(moved);
  poke.plus.standard_error_px[i] = poke.minus.standard_error_px[i] = {error_px, error_px};
}

std::string listed_numbers(const std::vector<int>& numbers) {
  constexpr std::size_t kMaxListed = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxListed, numbers.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
  }
  if (numbers.size() > kMaxListed) text += ", …";
  return text;
}

std::string percent(double part) {
  return std::to_string(std::lround(100.0 * part)) + " %";
}

std::string hundredths(double value) {
  std::string text = std::to_string(std::lround(100.0 * value));
  text.insert(0, text.size() < 3 ? 3 - text.size() : 0, '0');
  return text.insert(text.size() - 2, ".");
}

/// Spots that are found without a poke, both before and after.
std::vector<std::size_t> resting_spots(const PushPullRun& run) {
  std::vector<std::size_t> spots;
  for (std::size_t i = 0; i < run.before.at_px.size(); ++i) {
    if (found(run.before, i) && found(run.after, i)) spots.push_back(i);
  }
  return spots;
}

/// Matrix column in floats, as files store it, so that a matrix read from a file is identical. (GCC
/// 12 omits the rounding of double(float(value)) where it vectorises neighbours.)
struct Column {
  Eigen::VectorXf slopes, standard_error;
};

Column column_of(const PushPull& poke, const std::vector<std::size_t>& spots, std::size_t all) {
  Column c{Eigen::VectorXf::Zero(2 * Eigen::Index(all)),
           Eigen::VectorXf::Zero(2 * Eigen::Index(all))};
  const double by = 1.0 / (2.0 * poke.amplitude_waves);
  for (const std::size_t i : spots) {
    const auto row = 2 * Eigen::Index(i);
    const Vec2 moved = poke.plus.at_px[i] - poke.minus.at_px[i];
    const Vec2 &a = poke.plus.standard_error_px[i], &b = poke.minus.standard_error_px[i];
    c.slopes(row) = float(by * moved.x);
    c.slopes(row + 1) = float(by * moved.y);
    c.standard_error(row) = float(by * std::hypot(a.x, b.x));
    c.standard_error(row + 1) = float(by * std::hypot(a.y, b.y));
  }
  return c;
}

/// Appends the column if all modes are still determined; returns whether it was appended.
bool append(InteractionMatrix& matrix, const Column& column) {
  const Eigen::Index before = matrix.slopes.cols();
  Eigen::MatrixXd with(column.slopes.size(), before + 1);
  with << matrix.slopes, column.slopes.cast<double>();
  if (determined_modes(with) != int(with.cols())) return false;
  if (double(column.standard_error.norm()) > kMaxNoise * singular_values(with).tail(1)[0])
    return false;
  matrix.slopes = std::move(with);
  matrix.standard_error.conservativeResize(Eigen::NoChange, before + 1);
  matrix.standard_error.col(before) = column.standard_error.cast<double>();
  return true;
}

/// Appends the column of mode `j`. Returns why it cannot be appended; empty: it was.
std::string take_column(InteractionMatrix& matrix, const Column& column, int j,
                        double amplitude_waves) {
  const double signal = double(column.slopes.norm());
  const double noise = double(column.standard_error.norm());
  if (signal == 0.0) return "it moves no spot";
  if (!(noise <= kMaxNoise * signal)) {
    return "its noise is " + percent(noise / signal) +
           " of its signal: average more frames, raise the laser power or the exposure, or raise "
           "amplitude_waves";
  }
  if (!append(matrix, column)) {
    return "it is not determined: the spots cannot distinguish it from the modes before it";
  }
  matrix.modes_j.push_back(j);
  matrix.amplitude_waves.push_back(amplitude_waves);
  return {};
}

void begin_columns(InteractionMatrix& matrix, std::size_t spots) {
  matrix.slopes.resize(2 * Eigen::Index(spots), 0);
  matrix.standard_error.resize(2 * Eigen::Index(spots), 0);
}

void take_columns(const PushPullRun& run, const std::vector<const PushPull*>& pokes,
                  const std::vector<std::size_t>& spots, InteractionMatrix& matrix) {
  const std::size_t all = run.before.at_px.size();
  begin_columns(matrix, all);
  for (const PushPull* poke : pokes) {
    std::string reason =
        take_column(matrix, column_of(*poke, spots, all), poke->j, poke->amplitude_waves);
    if (!reason.empty()) matrix.dropped.push_back({poke->j, std::move(reason)});
  }
}

}  // namespace

std::vector<int> lost_by(const PushPull& poke, const SpotMeans& resting) {
  std::vector<int> lost;
  for (std::size_t i = 0; i < resting.at_px.size(); ++i) {
    const bool there = found(poke.plus, i) && found(poke.minus, i);
    if (found(resting, i) && !there) lost.push_back(int(i));
  }
  return lost;
}

void fill_lost(const SpotMeans& resting, const Eigen::Ref<const Eigen::VectorXd>& model,
               PushPull& poke) {
  const std::vector<int> lost = lost_by(poke, resting);
  std::size_t spots = 0;
  for (std::size_t i = 0; i < resting.at_px.size(); ++i) spots += found(resting, i) ? 1 : 0;
  if (double(lost.size()) > kMaxLostByMode * double(spots)) return;
  const double factor = factor_of(poke, model);
  for (const int spot : lost) {
    const auto i = std::size_t(spot);
    if (found(poke.plus, i)) {
      mirror(poke.plus, resting, i, poke.minus);
    } else if (found(poke.minus, i)) {
      mirror(poke.minus, resting, i, poke.plus);
    } else {
      follow_model(resting, factor * model.segment<2>(2 * spot), i, poke);
    }
  }
}

SpotDrift drift_between(const SpotMeans& first, const SpotMeans& second) {
  double squares = 0.0, variance = 0.0, count = 0.0;
  for (std::size_t i = 0; i < first.at_px.size(); ++i) {
    if (!found(first, i) || !found(second, i)) continue;
    const Vec2 moved = second.at_px[i] - first.at_px[i];
    const Vec2 &a = first.standard_error_px[i], &b = second.standard_error_px[i];
    squares += moved.x * moved.x + moved.y * moved.y;
    variance += a.x * a.x + a.y * a.y + b.x * b.x + b.y * b.y;
    count += 2.0;
  }
  if (count == 0.0) return {};
  return {std::sqrt(squares / count), std::sqrt(variance / count)};
}

SpotMeans mean_of_both(const SpotMeans& first, const SpotMeans& second) {
  SpotMeans mean = first;
  for (std::size_t i = 0; i < mean.at_px.size(); ++i) {
    const Vec2 &a = first.standard_error_px[i], &b = second.standard_error_px[i];
    mean.at_px[i] = 0.5 * (first.at_px[i] + second.at_px[i]);
    mean.standard_error_px[i] = {0.5 * std::hypot(a.x, b.x), 0.5 * std::hypot(a.y, b.y)};
  }
  return mean;
}

Result<InteractionMatrix> interaction_matrix(const PushPullRun& run, double max_drift_px) {
  InteractionMatrix matrix;
  const auto resting = resting_spots(run);
  const SpotDrift drift = drift_between(run.before, run.after);
  matrix.drift_px = drift.rms_px;
  matrix.drift_noise_px = drift.noise_px;
  if (matrix.drift_px > max_drift_px) {
    return fail(Errc::refused, "",
                "at rest the spots have moved by " + hundredths(matrix.drift_px) +
                    " px RMS since the beginning (limit " + hundredths(max_drift_px) +
                    " px): let the bench settle, and measure again");
  }
  std::vector<const PushPull*> pokes;
  std::vector<bool> lost(run.before.at_px.size(), true);
  for (const std::size_t i : resting) lost[i] = false;
  for (const PushPull& poke : run.modes) {
    const std::vector<int> gone = lost_by(poke, run.before);
    if (double(gone.size()) > kMaxLostByMode * double(resting.size())) {
      matrix.dropped.push_back({poke.j, "its images lose the spots " + listed_numbers(gone) +
                                            ": lower amplitude_waves"});
      continue;
    }
    for (const int i : gone) lost[std::size_t(i)] = true;
    pokes.push_back(&poke);
  }
  std::vector<std::size_t> spots;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    if (lost[i]) {
      matrix.lost_spots.push_back(int(i));
    } else {
      spots.push_back(i);
    }
  }
  if (spots.size() < kMinMatrixSpots) {
    return fail(Errc::refused, "",
                "only " + std::to_string(spots.size()) +
                    " spots are found in every image: check the exposure and the region of "
                    "interest, or lower amplitude_waves");
  }
  take_columns(run, pokes, spots, matrix);
  if (!matrix.modes_j.empty()) return matrix;
  return fail(Errc::refused, "",
              "no mode can be measured: " + (matrix.dropped.empty()
                                                 ? std::string("none was requested")
                                                 : "j = " + std::to_string(matrix.dropped[0].j) +
                                                       ": " + matrix.dropped[0].reason));
}

Result<InteractionMatrix> interaction_matrix(const std::vector<int>& modes_j,
                                             double amplitude_waves, const Eigen::MatrixXf& slopes,
                                             const Eigen::MatrixXf& standard_error) {
  InteractionMatrix matrix;
  matrix.source = MatrixSource::set;
  const Eigen::Index spots = slopes.rows() / 2;
  begin_columns(matrix, std::size_t(spots));
  for (Eigen::Index i = 0; i < spots; ++i) {
    if (slopes.middleRows(2 * i, 2).isZero(0.0F)) matrix.lost_spots.push_back(int(i));
  }
  const std::size_t found = std::size_t(spots) - matrix.lost_spots.size();
  if (found < kMinMatrixSpots) {
    return fail(Errc::refused, "matrix",
                "only " + std::to_string(found) + " spots move, and at least " +
                    std::to_string(kMinMatrixSpots) +
                    " are needed: check the light and the region of interest");
  }
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    const Column column{slopes.col(Eigen::Index(k)), standard_error.col(Eigen::Index(k))};
    const std::string reason = take_column(matrix, column, modes_j[k], amplitude_waves);
    if (reason.empty()) continue;
    return fail(Errc::refused, "matrix", "j = " + std::to_string(modes_j[k]) + ": " + reason);
  }
  return matrix;
}

double relative_noise(const InteractionMatrix& matrix, Eigen::Index k) {
  return matrix.standard_error.col(k).norm() / matrix.slopes.col(k).norm();
}

}  // namespace ovws
