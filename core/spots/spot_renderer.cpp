#include "core/spots/spot_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "core/base/complex_product.hpp"
#include "core/base/decompositions.hpp"
#include "core/optics/complex_matrices.hpp"
#include "core/spots/spot_sums.hpp"

namespace ovws {
namespace {

constexpr int kAmplitudeModes = 9, kFewAmplitudeModes = 5, kManySpots = 19;
static_assert(kMinSide >= kMinProductRows, "a window is wide enough for PieceMoments");
constexpr double kNearestPitches = 1.6;  // of a lattice: those beside and across
constexpr double kMaxDerivatives = 1e8;  // 400 MB
constexpr double kAmplitudeRidge = 1e-3, kLeastAmplitude = 0.05;

/// Least-squares fit of low modes to `values` (logarithms of amplitudes) at the spots' centres.
std::vector<Mode> smooth_over(const SpotRenderer& renderer, const std::vector<double>& values) {
  const int count = renderer.spots() >= kManySpots ? kAmplitudeModes : kFewAmplitudeModes;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(count + 1, count + 1) * kAmplitudeRidge;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count + 1), row(count + 1);
  for (int i = 0; i < renderer.spots(); ++i) {
    for (int j = 0; j <= count; ++j) row(j) = zernike(j, renderer.centre(i));
    normal += row * row.transpose();
    right += values[std::size_t(i)] * row;
  }
  const Eigen::VectorXd solved = solve_symmetric(normal, right);
  std::vector<Mode> modes;
  for (int j = 0; j <= count; ++j) modes.push_back({j, solved(j)});
  return modes;
}

std::vector<Mode> modes_of(const std::vector<int>& modes_j, std::span<const double> waves,
                           std::span<const Mode> fixed) {
  std::vector<Mode> modes(fixed.begin(), fixed.end());
  for (std::size_t k = 0; k < modes_j.size(); ++k) modes.push_back({modes_j[k], waves[k]});
  return modes;
}

/// Converts values at the centre of each binned pixel to sums over its camera pixels. For 2 x 2
/// pixels, three neighbouring binned pixels give the second derivative.
void sum_over_cells(const SpotWindow& window, Eigen::MatrixXf& columns) {
  if (window.bin == 1) return;
  const auto side = Eigen::Index(window.side);
  const auto curve = float(window.bin * window.bin - 1) / float(24 * window.bin * window.bin);
  Eigen::MatrixXf smooth(side, side);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Eigen::Map<Eigen::MatrixXf> cells(columns.col(k).data(), side, side);
    smooth = cells;
    smooth.middleRows(1, side - 2) +=
        curve * (cells.topRows(side - 2) - 2.0F * cells.middleRows(1, side - 2) +
                 cells.bottomRows(side - 2));
    cells = smooth;
    cells.middleCols(1, side - 2) +=
        curve * (smooth.leftCols(side - 2) - 2.0F * smooth.middleCols(1, side - 2) +
                 smooth.rightCols(side - 2));
  }
  columns *= float(window.bin * window.bin);
}

}  // namespace

Result<SpotRenderer> SpotRenderer::make(const SensorConfig& sensor, const SlmGeometry& slm,
                                        const OpticsConfig& optics, int cols, int rows,
                                        std::vector<int> modes_j, const Options& options) {
  auto field = SensorField::make(sensor, slm, optics, cols, rows);
  if (!field) return fail(field.error());
  const double spot_px = lambda_d_px(optics, slm, sensor);
  const double half_width =
      options.half_width > 0.0 ? options.half_width
                               : window_half_width(int(modes_j.size()), sensor.subapertures_across);
  const SpotWindow window = window_of(spot_px, half_width, options.lit);
  if (window.width_px() > std::min(cols, rows)) {
    return fail(Errc::invalid, "optics",
                "a window of " + std::to_string(window.width_px()) +
                    " pixels around a spot does not fit into the image");
  }
  field->set_outside(options.light_outside);
  // The light of a lenslet reaches the spots of those beside it, however far apart they are.
  const double neighbour_px = kNearestPitches * sensor.lenslets.width_px;
  const double reach_px = std::max(options.reach * spot_px, neighbour_px);
  if (double(window.cells()) * double(modes_j.size()) * field->subapertures() > kMaxDerivatives) {
    return fail(Errc::refused, "tracking.mode_count",
                "the shapes of so many spots do not fit into memory for so many modes: use the "
                "tracker lg, or fewer modes");
  }
  return SpotRenderer(std::move(*field), std::move(modes_j), window, reach_px);
}

SpotRenderer::SpotRenderer(SensorField field, std::vector<int> modes_j, SpotWindow window,
                           double reach_px)
    : field_(std::move(field)),
      modes_j_(std::move(modes_j)),
      moments_(field_, modes_j_),
      window_(window),
      reach_px_(reach_px) {
  const std::vector<double> flat(modes_j_.size(), 0.0);
  float brightest = 0.0F;
  for (const RenderedSpot& spot : render(flat)) {
    brightest = std::max(brightest, spot.light.maxCoeff());
  }
  if (brightest > 0.0F) to_intensity_ = 1.0 / double(brightest);
}

std::vector<RenderedSpot> SpotRenderer::render(std::span<const double> waves,
                                               std::span<const Mode> fixed) {
  const std::vector<Mode> modes = modes_of(modes_j_, waves, fixed);
  const FarFieldWindow& image = field_.window();
  propagate(modes, deviations_.fields);
  std::vector<int> pieces(spots());
  std::iota(pieces.begin(), pieces.end(), 0);
  moments_.load(field_, modes, pieces);
  std::vector<RenderedSpot> rendered(pieces.size());
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    rendered[i].place_px = moments_.falls_px(i, modes);
    if (i < deviations_.offsets_px.size()) {
      rendered[i].place_px = rendered[i].place_px + deviations_.offsets_px[i];
    }
  }
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    RenderedSpot& spot = rendered[i];
    spot.window = moved_to(spot.place_px, window_, image.cols, image.rows);
    spot.light.setZero(spot.window.cells());
    spot.per_wave.setZero(spot.window.cells(), Eigen::Index(modes_j_.size()));
    spot.per_px.setZero(spot.window.cells(), 2);
    if (!is_inside(spot)) continue;
    spot.light = intensity_in(spot.window);
    const Eigen::MatrixXcf far = field_of_cells(spot, field_.cells().pieces[i].centre_px);
    for (const int piece : pieces) {
      const bool own = piece == int(i);
      const double away = norm(rendered[std::size_t(piece)].place_px - spot.place_px);
      if (own || away < reach_px_) add_derivatives(spot, far, piece, own);
    }
    sum_over_cells(spot.window, spot.per_wave);
    sum_over_cells(spot.window, spot.per_px);
    sum_over_cells(spot.window, spot.per_monomial);
  }
  if (correction_) correction_->add_to(rendered, waves, fixed);
  return rendered;
}

std::vector<Eigen::VectorXf> SpotRenderer::light_in(std::span<const RenderedSpot> spots,
                                                    std::span<const double> waves,
                                                    std::span<const Mode> fixed) {
  propagate(modes_of(modes_j_, waves, fixed), deviations_.fields);
  std::vector<Eigen::VectorXf> light;
  for (const RenderedSpot& spot : spots) light.push_back(intensity_in(spot.window));
  return light;
}

/// Propagates the field with the deviations. Outside the subapertures, the amplitude is a smooth
/// continuation of theirs.
void SpotRenderer::propagate(std::span<const Mode> modes,
                             std::span<const SensorField::LocalField> fields) {
  std::vector<Vec2> slopes_cpp;
  for (const Vec2 offset : deviations_.offsets_px) {
    slopes_cpp.push_back(field_.window().step_cpp * offset);
  }
  std::vector<double> ln;
  for (const SensorField::LocalField& field : deviations_.fields) {
    ln.push_back(std::log(std::max(kLeastAmplitude, std::abs(1.0 + field[0]))));
  }
  const std::vector<Mode> outside = ln.empty() ? std::vector<Mode>{} : smooth_over(*this, ln);
  field_.propagate(modes, {slopes_cpp, fields, outside});
}

std::vector<Eigen::MatrixXf> SpotRenderer::per_field(std::span<const RenderedSpot> rendered,
                                                     std::span<const double> waves,
                                                     std::span<const Mode> fixed) {
  constexpr auto kMoments = Eigen::Index(PieceMoments::kCount);
  std::vector<Eigen::MatrixXcf> far;
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    far.push_back(field_of_cells(rendered[i], field_.cells().pieces[i].centre_px));
  }
  const std::vector<Mode> modes = modes_of(modes_j_, waves, fixed);
  propagate(modes, {});  // moments are those of the model without local fields
  std::vector<int> pieces(rendered.size());
  std::iota(pieces.begin(), pieces.end(), 0);
  moments_.load(field_, modes, pieces);
  std::vector<Eigen::MatrixXf> all;
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    const SpotWindow& window = rendered[i].window;
    const Eigen::MatrixXcf& moments = moments_.at(int(i), middles_of(window));
    const Eigen::Map<const Eigen::ArrayXcf> field(far[i].data(), far[i].size());
    Eigen::MatrixXf& change = all.emplace_back(window.cells(), 2 * kMoments);
    for (Eigen::Index k = 0; k < kMoments; ++k) {
      const Eigen::ArrayXcf both =
          float(2.0 * to_intensity_) * field.conjugate() * moments.col(k).array();
      change.col(k) = both.real();
      change.col(kMoments + k) = -both.imag();
    }
    sum_over_cells(window, change);
  }
  return all;
}

FarPoints SpotRenderer::middles_of(const SpotWindow& window) const {
  const double middle = 0.5 * (window.bin - 1);
  return {Vec2{window.left + middle, window.top + middle}, window.side, window.side,
          double(window.pitch())};
}

Eigen::VectorXf SpotRenderer::intensity_in(const SpotWindow& window) const {
  Eigen::VectorXf light = Eigen::VectorXf::Zero(window.cells());
  each_pixel(window, [&](Eigen::Index cell, int x, int y) {
    light(cell) += float(to_intensity_) * std::norm(field_.far().row(y)[x]);
  });
  return light;
}

/// Complex field at the centre of each binned pixel, x along the rows. Within a binned pixel, the
/// field of the spot's own subaperture changes mainly by a phase ramp, which is removed.
/// `centre_px` is the subaperture's centre on the SLM, from the pupil's centre.
Eigen::MatrixXcf SpotRenderer::field_of_cells(const RenderedSpot& spot, Vec2 centre_px) const {
  const SpotWindow& window = spot.window;
  const PixelBox box = window.pixels();
  Eigen::MatrixXcf cells = Eigen::MatrixXcf::Zero(window.side, window.side);
  for (int k = 0; k < window.bin * window.bin; ++k) {
    const int column = k % window.bin, row = k / window.bin;
    const double middle = 0.5 * (window.bin - 1), step_cpp = field_.window().step_cpp;
    const double cycles =
        step_cpp * ((column - middle) * centre_px.x + (row - middle) * centre_px.y);
    const auto back = std::complex<float>(
        std::polar(1.0 / (window.bin * window.bin), 2.0 * std::numbers::pi * cycles));
    for (int y = 0; y < window.side; ++y) {
      const std::complex<float>* far = field_.far().row(box.y + row + y * window.pitch()) + box.x;
      for (int x = 0; x < window.side; ++x) {
        cells(x, y) += product(back, far[column + x * window.pitch()]);
      }
    }
  }
  return cells;
}

/// Adds the intensity derivatives at the centre of each binned pixel. A phase of p(xi, eta) waves
/// over a subaperture changes the intensity by 2 Re(2 pi i conj(F) M), where M is the moment of p.
void SpotRenderer::add_derivatives(RenderedSpot& spot, const Eigen::MatrixXcf& far, int piece,
                                   bool own) {
  const SpotWindow& window = spot.window;
  const Eigen::MatrixXcf& moments = moments_.at(piece, middles_of(window));
  const auto factor = float(-4.0 * std::numbers::pi * to_intensity_);
  const Eigen::Map<const Eigen::ArrayXcf> field(far.data(), far.size());
  const Eigen::ArrayXf re = factor * field.real(), im = factor * field.imag();
  Eigen::MatrixXf cells(moments.rows(), moments.cols());
  for (Eigen::Index k = 0; k < moments.cols(); ++k) {
    cells.col(k) = re * moments.col(k).imag().array() - im * moments.col(k).real().array();
  }
  spot.per_wave.noalias() += cells * moments_.modes_over(piece).transpose();
  if (!own) return;
  const double radius_px = field_.cells().pieces[std::size_t(piece)].radius_px;
  const auto per_px = float(field_.window().step_cpp * radius_px);  // tilt in waves at the edge
  spot.per_px.col(0) = per_px * cells.col(PieceMoments::kAlongX);
  spot.per_px.col(1) = per_px * cells.col(PieceMoments::kAlongY);
  spot.per_monomial = std::move(cells);
  spot.higher = moments_.higher_over(piece);
  spot.higher_rest = moments_.higher_rest(piece);
}

}  // namespace ovws
