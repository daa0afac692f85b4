#include "core/wavefront/shape_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

constexpr int kMaxRounds = 14;          // alternations of modes and spots
constexpr int kMaxStrictRounds = 7;     // at most, with strict acceptance
constexpr double kMinIntensity = 0.05;  // of a spot's maximum: darker bins are ignored
constexpr int kMinBins = 12;
constexpr double kMinSignificance = 5.0;
constexpr double kMaxAmplitude = 1.8;     // of the usual amplitude
constexpr double kStartError = 0.05;      // lambda/d: standard error of a start
constexpr double kShapeError = 0.15;      // of the amplitude: error of a bin due to interference
constexpr double kConverged = 0.02;       // waves RMS: a smaller step has converged
constexpr double kPredictionError = 0.1;  // lambda/d: standard error of the wavefront's prediction
constexpr double kLocalWaves = 0.05;      // waves: standard deviation of a spot's other local modes
constexpr double kMaxStep = 0.3;          // waves per round
constexpr std::size_t kNeighbours = 7;

/// Prior standard deviation of a mode, waves. It regularises a wavefront of which only the middle
/// is seen.
double prior_waves(int j) {
  constexpr std::array<double, 6> kByOrder{3.0, 3.0, 3.0, 0.5, 0.35, 0.3};
  return kByOrder[std::size_t(std::min(5, zernike_index(j).n))];
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Parabolic interpolation: where the maximum through three values lies, from the middle one.
double vertex(double before, double at, double after) {
  const double bend = before - 2.0 * at + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

bool is_known(Vec2 at) {
  return !std::isnan(at.x);
}

}  // namespace

ShapeFit::ShapeFit(const ShapeModel& model, const BinnedImage& image)
    : model_(model),
      image_(image),
      waves_(Eigen::VectorXd::Zero(model.slopes.cols())),
      spots_(model.reference_px.size()),
      rendered_(spots_.size()) {}

int ShapeFit::run(std::span<const Vec2> starts_px) {
  if (std::none_of(starts_px.begin(), starts_px.end(), is_known)) return 0;
  fit_modes_to_positions(starts_px);
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    rendered_[i] = {};
    spots_[i] = {is_known(starts_px[i]), starts_px[i]};
    render(int(i));
    if (!spots_[i].found) continue;
    spots_[i].amplitude = match(int(i), 0, 0).amplitude;
  }
  update_spots({0.8, 0.5, 0.4, 1.0});
  int found = 0;
  bool strict = true;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double step_waves = fit_modes_to_shapes();
    update_spots(strict ? Rules{0.8, 0.4, 0.6, 0.8} : Rules{0.8, 0.8, 0.6, 0.5});
    const int previously_found = found;
    found = int(std::count_if(spots_.begin(), spots_.end(), [](const auto& s) { return s.found; }));
    const bool at_rest = step_waves < kConverged && found <= previously_found;
    if (!strict && (at_rest || (step_waves < kConverged && found == int(spots_.size())))) break;
    strict = strict && !at_rest && round < kMaxStrictRounds;
  }
  refine_positions();
  return found;
}

/// Final positions: each spot's local modes may differ only a little from the common wavefront, so
/// that noise cannot move a long, faint spot far along itself.
void ShapeFit::refine_positions() {
  const double tilt =
      kPredictionError * model_.lambda_d_px / model_.bin_px() / model_.optics.cells_per_tilt();
  Eigen::Matrix<double, SpotOptics::kLocal, 1> weights;
  weights.setConstant(std::pow(kLocalWaves, -2));
  weights.head<2>().setConstant(std::pow(tilt, -2));
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    if (!spots_[i].found) continue;
    add(int(i), -1.0);
    const Information info = information(int(i));
    add(int(i), 1.0);
    const Local normal = info.matrix + Local(weights.asDiagonal());
    const auto own = normal.ldlt().solve(info.gradient).eval();
    const Vec2 offset{own(1), own(0)};
    spots_[i].at_px = image_.to_px(predicted_bin(int(i)) + model_.optics.cells_per_tilt() * offset);
  }
}

Eigen::VectorXd ShapeFit::prior_weights() const {
  Eigen::VectorXd weights(waves_.size());
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    weights(k) = 1.0 / std::pow(prior_waves(model_.optics.modes_j()[std::size_t(k)]), 2);
  }
  return weights;
}

void ShapeFit::fit_modes_to_positions(std::span<const Vec2> starts_px) {
  Eigen::MatrixXd normal = prior_weights().asDiagonal();
  Eigen::VectorXd right_side = Eigen::VectorXd::Zero(waves_.size());
  const double weight = std::pow(kStartError * model_.lambda_d_px, -2);
  for (std::size_t i = 0; i < starts_px.size(); ++i) {
    if (!is_known(starts_px[i])) continue;
    const Vec2 moved = starts_px[i] - model_.reference_px[i];
    const auto rows = model_.slopes.middleRows(Eigen::Index(2 * i), 2);
    normal += weight * rows.transpose() * rows;
    right_side += weight * rows.transpose() * Eigen::Vector2d(moved.x, moved.y);
  }
  waves_ = normal.ldlt().solve(right_side);
}

Vec2 ShapeFit::predicted_bin(int spot) const {
  const Eigen::Vector2d moved = model_.slopes.middleRows(2 * Eigen::Index(spot), 2) * waves_;
  return image_.to_bins(model_.reference_px[std::size_t(spot)] + Vec2{moved.x(), moved.y()});
}

void ShapeFit::render(int spot) {
  Rendered& rendered = rendered_[std::size_t(spot)];
  const Vec2 at = predicted_bin(spot) + rendered.offset;
  const double column = std::round(at.x), row = std::round(at.y);
  const int half = model_.optics.half_cells();
  rendered.intensity = model_.optics.intensity(spot, waves_, {at.x - column, at.y - row});
  rendered.column = int(column) - half;
  rendered.row = int(row) - half;
}

/// Calls `cell(y, x, intensity)` for the bins of a computed spot that lie inside the image.
template <class Cell>
void each_cell(const Eigen::MatrixXf& picture, int row, int column, Eigen::Index rows,
               Eigen::Index columns, Cell&& cell) {
  const auto clipped = [](int first, Eigen::Index size) { return std::max(0, -first) < size; };
  if (!clipped(row, picture.rows()) || !clipped(column, picture.cols())) return;
  const int bottom = int(std::min(picture.rows(), rows - row));
  const int right = int(std::min(picture.cols(), columns - column));
  for (int x = std::max(0, -column); x < right; ++x) {
    for (int y = std::max(0, -row); y < bottom; ++y) cell(row + y, column + x, picture(y, x));
  }
}

void ShapeFit::add(int spot, double sign) {
  const Rendered& rendered = rendered_[std::size_t(spot)];
  const auto amplitude = float(sign * spots_[std::size_t(spot)].amplitude);
  each_cell(rendered.intensity, rendered.row, rendered.column, others_.rows(), others_.cols(),
            [&](int y, int x, float intensity) { others_(y, x) += amplitude * intensity; });
}

ShapeFit::Match ShapeFit::match(int spot, int right, int down) const {
  const Rendered& rendered = rendered_[std::size_t(spot)];
  const float threshold = float(kMinIntensity) * rendered.intensity.maxCoeff();
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  each_cell(rendered.intensity, rendered.row + down, rendered.column + right,
            image_.intensity.rows(), image_.intensity.cols(),
            [&](int row, int column, float intensity) {
              if (intensity < threshold) return;
              const float over = others_.size() > 0 ? others_(row, column) : 0.0F;
              const auto t = double(intensity), v = double(image_.intensity(row, column) - over);
              n += 1.0, x += t, y += v, xx += t * t, xy += t * v, yy += v * v;
            });
  if (n < kMinBins) return {};
  const double txx = xx - x * x / n, txy = xy - x * y / n, tyy = yy - y * y / n;
  Match m;
  m.amplitude = txy / txx;
  if (!(m.amplitude > 0.0)) return {};
  m.explained = m.amplitude * txy;
  const double left = std::max(0.0, tyy - m.explained - n * image_.noise * image_.noise);
  m.unexplained = left / (left + m.explained);
  m.significance = m.amplitude * std::sqrt(txx) / image_.noise;
  return m;
}

double ShapeFit::usual_amplitude(int spot) const {
  std::vector<std::pair<double, double>> near;  // distance, amplitude
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    if (!spots_[i].found || int(i) == spot || !(spots_[i].amplitude > 0.0)) continue;
    near.emplace_back(norm(model_.reference_px[i] - model_.reference_px[std::size_t(spot)]),
                      spots_[i].amplitude);
  }
  if (near.empty()) return spots_[std::size_t(spot)].amplitude;
  std::sort(near.begin(), near.end());
  std::vector<double> amplitudes;
  for (std::size_t k = 0; k < std::min(kNeighbours, near.size()); ++k) {
    amplitudes.push_back(near[k].second);
  }
  return median(amplitudes);
}

bool ShapeFit::accepted(int spot, const Match& match, const Rules& rules) const {
  const double usual = usual_amplitude(spot);
  return match.significance > kMinSignificance && match.unexplained < rules.max_unexplained &&
         match.amplitude > rules.min_amplitude * usual && match.amplitude < kMaxAmplitude * usual &&
         norm(rendered_[std::size_t(spot)].offset) * model_.bin_px() <
             rules.max_offset * model_.lambda_d_px;
}

void ShapeFit::search(int spot, const Rules& rules) {
  constexpr double kFollowRadius = 0.4;  // lambda/d: search radius around a found spot
  ShapedSpot& s = spots_[std::size_t(spot)];
  Rendered& rendered = rendered_[std::size_t(spot)];
  const double reach =
      (s.found ? kFollowRadius : rules.reach) * model_.lambda_d_px / model_.bin_px();
  rendered.offset = {};
  render(spot);
  Match best;
  int right = 0, down = 0;
  for (int dy = -int(reach); dy <= int(reach); ++dy) {
    for (int dx = -int(reach); dx <= int(reach); ++dx) {
      if (dx * dx + dy * dy > reach * reach) continue;
      const Match here = match(spot, dx, dy);
      if (here.explained <= best.explained) continue;
      best = here, right = dx, down = dy;
    }
  }
  const auto explained = [&](int dx, int dy) {
    return match(spot, right + dx, down + dy).explained;
  };
  rendered.offset = {right + vertex(explained(-1, 0), best.explained, explained(1, 0)),
                     down + vertex(explained(0, -1), best.explained, explained(0, 1))};
  render(spot);
  best = match(spot, 0, 0);
  const bool found = accepted(spot, best, rules);
  if (!found) rendered.offset = {};
  s = {found, image_.to_px(predicted_bin(spot) + rendered.offset), best.amplitude,
       best.unexplained};
}

void ShapeFit::update_spots(const Rules& rules) {
  others_.setZero(image_.intensity.rows(), image_.intensity.cols());
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    rendered_[i].offset =
        spots_[i].found ? image_.to_bins(spots_[i].at_px) - predicted_bin(int(i)) : Vec2{};
    render(int(i));
    if (spots_[i].found) add(int(i), 1.0);
  }
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    if (spots_[i].found) add(int(i), -1.0);
    search(int(i), rules);
    if (spots_[i].found) add(int(i), 1.0);
  }
}

/// Gauss-Newton normal equations at the spot's position in its local modes, amplitude and
/// background. The last two are eliminated (Schur complement).
ShapeFit::Information ShapeFit::information(int spot) const {
  constexpr int kLocal = SpotOptics::kLocal, kAll = kLocal + 2;
  const Rendered& rendered = rendered_[std::size_t(spot)];
  const Vec2 at = predicted_bin(spot) + rendered.offset;
  const auto derived =
      model_.optics.derive(spot, waves_, {at.x - std::round(at.x), at.y - std::round(at.y)});
  const double amplitude = spots_[std::size_t(spot)].amplitude;
  const float threshold = float(kMinIntensity) * derived.intensity.maxCoeff();
  const double variance = std::pow(image_.noise, 2) + std::pow(kShapeError * amplitude, 2);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(kAll, kAll);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kAll), row(kAll);
  const int side = 2 * model_.optics.half_cells() + 1;
  for (int c = 0; c < side; ++c) {
    for (int r = 0; r < side; ++r) {
      const int y = rendered.row + r, x = rendered.column + c;
      if (derived.intensity(r, c) < threshold || y < 0 || x < 0 || y >= image_.intensity.rows() ||
          x >= image_.intensity.cols()) {
        continue;
      }
      for (int k = 0; k < kLocal; ++k) row(k) = amplitude * double(derived.per_wave[k](r, c));
      row(kLocal) = double(derived.intensity(r, c));
      row(kLocal + 1) = 1.0;
      const double off = double(image_.intensity(y, x) - others_(y, x)) - amplitude * row(kLocal);
      all.selfadjointView<Eigen::Lower>().rankUpdate(row, 1.0 / variance);
      gradient += off / variance * row;
    }
  }
  all = Eigen::MatrixXd(all.selfadjointView<Eigen::Lower>());
  const Eigen::MatrixXd cross =
      all.topRightCorner(kLocal, 2) * all.bottomRightCorner<2, 2>().inverse();
  Information info{Local::Zero(), Eigen::Matrix<double, kLocal, 1>::Zero()};
  if (!cross.allFinite()) return info;
  info.matrix = all.topLeftCorner(kLocal, kLocal) - cross * all.bottomLeftCorner(2, kLocal);
  info.gradient = gradient.head(kLocal) - cross * gradient.tail(2);
  info.gradient += info.matrix.leftCols<2>() * offset_tilts(spot);
  return info;
}

/// The spot's offset from the wavefront's prediction as local tilts, waves: y, then x (j = 1, 2).
Eigen::Vector2d ShapeFit::offset_tilts(int spot) const {
  const Vec2 offset = rendered_[std::size_t(spot)].offset;
  return Eigen::Vector2d(offset.y, offset.x) / model_.optics.cells_per_tilt();
}

double ShapeFit::fit_modes_to_shapes() {
  Eigen::MatrixXd normal = prior_weights().asDiagonal();
  Eigen::VectorXd right_side = Eigen::VectorXd::Zero(waves_.size());
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    if (!spots_[i].found) continue;
    add(int(i), -1.0);
    const Information info = information(int(i));
    add(int(i), 1.0);
    const Eigen::MatrixXd& local = model_.optics.local_modes(int(i));
    normal += local.transpose() * info.matrix * local;
    right_side += local.transpose() * (info.gradient + info.matrix * local * waves_);
  }
  const Eigen::VectorXd step = normal.ldlt().solve(right_side) - waves_;
  if (!step.allFinite()) return 0.0;
  waves_ += std::min(1.0, kMaxStep / std::max(1e-12, step.norm())) * step;
  return step.norm();
}

}  // namespace ovws
