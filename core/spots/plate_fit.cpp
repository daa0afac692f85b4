#include "core/spots/plate_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/decompositions.hpp"
#include "core/optics/lattice.hpp"
#include "core/spots/measured_spots.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr double kPatchPitches = 5.0;  // radius around the centre in which lenslets are rendered
constexpr double kNeighbourPitches = 1.6;  // a fitted spot needs the light of these neighbours
constexpr int kMinSpots = 4, kMaxRounds = 25, kFreeRounds = 5;
constexpr int kModes = 9;                                    // of the light, over the patch
constexpr std::array<double, 3> kProbe{0.02, 0.03, 0.03};    // depth; shift in pitches
constexpr double kLongestDepth = 0.1, kLongestShift = 0.04;  // of a step
constexpr double kConverged = 2e-3, kMaxMisfit = 0.3;
// Monomials of a spot's own phase, as PieceMoments counts them: degree 2 and less.
constexpr std::array<Eigen::Index, 6> kOwnPhase{0, 1, 2, 4, 5, 7};
constexpr Eigen::Index kPhaseAlongY = 1, kPhaseAlongX = 3;  // of them
constexpr Eigen::Index kNuisances = 2 + kOwnPhase.size();

using Three = Eigen::Vector3d;

/// The lenslets that are rendered, a sensor of their own.
struct Patch {
  SensorConfig sensor;
  std::vector<Vec2> found_px;
  std::vector<char> fitted;  ///< whether the neighbours are rendered, too
};

Patch patch_of(const SensorConfig& sensor, std::span<const Vec2> found_px) {
  const Lenslets& all = sensor.lenslets;
  const double reach_px = kPatchPitches * all.width_px;
  Patch patch{sensor, {}, {}};
  patch.sensor.lenslets.centres_px.clear();
  patch.sensor.pupil_diameter_px = std::min(sensor.pupil_diameter_px, 2.0 * reach_px);
  for (std::size_t i = 0; i < all.centres_px.size(); ++i) {
    if (norm(all.centres_px[i]) > reach_px) continue;
    patch.sensor.lenslets.centres_px.push_back(all.centres_px[i]);
    patch.found_px.push_back(found_px[i]);
  }
  const auto& centres = patch.sensor.lenslets.centres_px;
  const auto neighbours = [&](Vec2 at) {
    return std::count_if(centres.begin(), centres.end(), [&](Vec2 other) {
      return norm(other - at) < kNeighbourPitches * all.width_px;
    });
  };
  std::vector<std::ptrdiff_t> counts;
  for (const Vec2 at : centres) counts.push_back(neighbours(at));
  const auto most = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    patch.fitted.push_back(counts[i] == most && std::isfinite(patch.found_px[i].x) ? 1 : 0);
  }
  return patch;
}

/// The light of the fit: modes over the patch, and what they leave of each spot's displacement.
struct Light {
  std::vector<double> waves;
  std::vector<Vec2> offsets_px;
};

/// Splits displacements from the model's places (NaN: unknown) into modes and a rest.
Light light_of(const Eigen::MatrixXd& px_per_wave, const std::vector<Vec2>& displaced_px) {
  std::vector<Eigen::Index> known;
  for (std::size_t i = 0; i < displaced_px.size(); ++i) {
    if (!std::isfinite(displaced_px[i].x)) continue;
    known.push_back(2 * Eigen::Index(i));
    known.push_back(2 * Eigen::Index(i) + 1);
  }
  Eigen::VectorXd right(Eigen::Index(known.size()));
  Eigen::MatrixXd rows(right.size(), px_per_wave.cols());
  for (Eigen::Index k = 0; k < right.size(); ++k) {
    const Vec2 at = displaced_px[std::size_t(known[std::size_t(k)] / 2)];
    right(k) = k % 2 == 0 ? at.x : at.y;
    rows.row(k) = px_per_wave.row(known[std::size_t(k)]);
  }
  const Eigen::VectorXd waves = least_squares(rows, right);
  const Eigen::VectorXd explained = px_per_wave * waves;
  Light light{{waves.begin(), waves.end()}, {}};
  for (std::size_t i = 0; i < displaced_px.size(); ++i) {
    const auto row = 2 * Eigen::Index(i);
    const bool is_known = std::isfinite(displaced_px[i].x);
    light.offsets_px.push_back(is_known ? displaced_px[i] - Vec2{explained(row), explained(row + 1)}
                                        : Vec2{});
  }
  return light;
}

/// Normal equations of the plate, with the nuisances of each spot eliminated.
struct Normal {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(3);
  double residual2 = 0.0, light2 = 0.0;
  int spots = 0;
  Eigen::Index cells = 0;

  Three step() const { return solve_symmetric(matrix, right); }
  double variance() const {
    return (residual2 - right.dot(step())) /
           double(std::max<Eigen::Index>(1, cells - kNuisances * spots));
  }
};

tl::unexpected<Error> too_few() {
  return fail(Errc::refused, "camera",
              "fewer than " + std::to_string(kMinSpots) +
                  " spots near the pupil's centre are found, not saturated, and have all their "
                  "neighbours: check light and exposure");
}

class PlateIteration {
 public:
  static Result<PlateIteration> make(const Image<float>& mean_dn, Patch patch,
                                     const SlmGeometry& slm, const OpticsConfig& optics,
                                     const LitPixels& lit) {
    if (std::count(patch.fitted.begin(), patch.fitted.end(), 1) < kMinSpots) return too_few();
    PlateIteration out(mean_dn, std::move(patch), slm, optics, lit);
    auto renderer = out.renderer_for(out.patch_.sensor.lenslets.plate);
    if (!renderer) return fail(renderer.error());
    const std::vector<double> flat(kModes, 0.0);
    for (const RenderedSpot& spot : renderer->render(flat)) {
      const std::size_t i = out.displaced_px_.size();
      // Only the positions of spots that are fitted become exact.
      const bool use = out.patch_.fitted[i] != 0;
      out.displaced_px_.push_back(use ? out.patch_.found_px[i] - spot.place_px : Vec2{NAN, NAN});
    }
    return out;
  }

  /// One round about `plate`: the normal equations of depth, shift_px x and y. Moves the light.
  Result<Normal> round(const SpiralPlate& plate) {
    auto renderer = renderer_for(plate);
    if (!renderer) return fail(renderer.error());
    const Light light = light_of(px_per_wave_, displaced_px_);
    renderer->set_deviations({light.offsets_px, {}});
    const std::vector<RenderedSpot> rendered = renderer->render(light.waves);
    std::array<std::vector<Eigen::VectorXf>, 3> changed;
    for (int k = 0; k < 3; ++k) {
      auto other = renderer_for(moved(plate, probe(k)));
      if (!other) return fail(other.error());
      other->set_deviations({light.offsets_px, {}});
      changed[std::size_t(k)] = other->light_in(rendered, light.waves, {});
    }
    std::vector<SpotWindow> windows;
    for (const RenderedSpot& spot : rendered) windows.push_back(spot.window);
    const SpotCells cells = cells_in(mean_dn_, windows);
    Normal sum;
    for (std::size_t i = 0; i < rendered.size(); ++i) {
      if (patch_.fitted[i] == 0 || !is_inside(rendered[i])) continue;
      if (!cells.col(Eigen::Index(i)).allFinite()) continue;
      Eigen::MatrixX3d by_plate(rendered[i].light.size(), 3);
      for (int k = 0; k < 3; ++k) {
        by_plate.col(k) =
            (changed[std::size_t(k)][i] - rendered[i].light).cast<double>() / probe(k)(k);
      }
      add(rendered[i], std::move(by_plate), cells.col(Eigen::Index(i)).cast<double>(),
          renderer->px_per_wave(int(i)), i, sum);
    }
    return sum;
  }

  Three probe(int k) const {
    const double width_px = patch_.sensor.lenslets.width_px;
    Three step = Three::Zero();
    step(k) = kProbe[std::size_t(k)] * (k == 0 ? 1.0 : width_px);
    return step;
  }
  static SpiralPlate moved(SpiralPlate plate, const Three& step) {
    plate.depth += step(0);
    plate.shift_px = plate.shift_px + Vec2{step(1), step(2)};
    return plate;
  }

 private:
  PlateIteration(const Image<float>& mean_dn, Patch patch, const SlmGeometry& slm,
                 const OpticsConfig& optics, const LitPixels& lit)
      : mean_dn_(mean_dn), patch_(std::move(patch)), slm_(slm), optics_(optics), lit_(lit) {
    modes_j_.resize(kModes);
    std::iota(modes_j_.begin(), modes_j_.end(), 1);
    optics_.centre_px = base_spot_px(optics, mean_dn.width, mean_dn.height);
    if (const auto lattice = make_lattice(patch_.sensor, slm_)) {
      px_per_wave_ = slope_matrix(*lattice, patch_.sensor, modes_j_, kGradientTilt,
                                  px_per_cycle(optics_, slm_));
    }
  }

  Result<SpotRenderer> renderer_for(const SpiralPlate& plate) const {
    SensorConfig sensor = patch_.sensor;
    sensor.lenslets.plate = plate;
    return SpotRenderer::make(sensor, slm_, optics_, mean_dn_.width, mean_dn_.height, modes_j_,
                              {.lit = lit_});
  }

  /// Adds one spot, and moves its displacement by the fit of its own phase.
  void add(const RenderedSpot& spot, Eigen::MatrixX3d by_plate, const Eigen::VectorXd& dn,
           double px_per_wave, std::size_t number, Normal& sum) {
    Eigen::MatrixXd own(spot.light.size(), kNuisances);
    own.col(0) = spot.light.cast<double>();
    own.col(1).setOnes();
    for (std::size_t k = 0; k < kOwnPhase.size(); ++k) {
      own.col(2 + Eigen::Index(k)) = spot.per_monomial.col(kOwnPhase[k]).cast<double>();
    }
    for (Eigen::Index cell = 0; cell < own.rows(); ++cell) {
      if (spot.window.is_lit(cell)) continue;
      own.row(cell).setZero();
      by_plate.row(cell).setZero();
    }
    // Scaled by the level, so that derivatives of the light are of the image.
    Eigen::MatrixXd given(own.rows(), 1 + by_plate.cols());
    given << dn, by_plate;
    const Eigen::MatrixXd found = least_squares(own, given);
    const Eigen::VectorXd solved = found.col(0);
    const double level = solved(0);
    if (!(level > 0.0)) return;
    const Eigen::VectorXd left = dn / level - own * (solved / level);
    const Eigen::MatrixXd changes = by_plate - own * found.rightCols(by_plate.cols());
    sum.matrix += changes.transpose() * changes;
    sum.right += changes.transpose() * left;
    sum.residual2 += left.squaredNorm();
    sum.light2 += spot.light.cast<double>().squaredNorm();
    sum.cells += left.size();
    ++sum.spots;
    const Vec2 tilt{solved(2 + kPhaseAlongX) / level, solved(2 + kPhaseAlongY) / level};
    const double most = 0.1 * patch_.sensor.lenslets.width_px;
    const Vec2 step = px_per_wave * tilt;
    displaced_px_[number] = displaced_px_[number] +
                            Vec2{std::clamp(step.x, -most, most), std::clamp(step.y, -most, most)};
  }

  const Image<float>& mean_dn_;
  Patch patch_;
  SlmGeometry slm_;
  OpticsConfig optics_;
  LitPixels lit_;
  std::vector<int> modes_j_;
  Eigen::MatrixXd px_per_wave_;
  std::vector<Vec2> displaced_px_;  ///< from the model without light's wavefront; NaN: unknown
};

}  // namespace

Result<PlateFit> fit_plate(const Image<float>& mean_dn, const SensorConfig& sensor,
                           const SlmGeometry& slm, const OpticsConfig& optics, const LitPixels& lit,
                           std::span<const Vec2> found_px, const std::function<bool()>& stopped) {
  if (sensor.lenslets.empty() || sensor.charge == 0) {
    return fail(Errc::refused, "sensor.charge", "bright lenslets (charge 0) have no spiral plates");
  }
  auto iteration = PlateIteration::make(mean_dn, patch_of(sensor, found_px), slm, optics, lit);
  if (!iteration) return fail(iteration.error());
  SpiralPlate plate = sensor.lenslets.plate;
  const double width_px = sensor.lenslets.width_px;
  for (int k = 0; k < kMaxRounds; ++k) {
    if (stopped()) return fail(Errc::refused, "", "the job was stopped");
    const auto normal = iteration->round(plate);
    if (!normal) return fail(normal.error());
    if (normal->spots < kMinSpots) return too_few();
    Three step = normal->step();
    const Three scaled{step(0) / kLongestDepth, step(1) / (kLongestShift * width_px),
                       step(2) / (kLongestShift * width_px)};
    const double longest = scaled.cwiseAbs().maxCoeff();
    if (!std::isfinite(longest)) break;
    if (longest > 1.0) step /= longest;
    // The cells' finite size makes the derivatives uneven: smaller steps end the hunting.
    if (k >= kFreeRounds) step *= 0.5;
    plate = PlateIteration::moved(plate, step);
    if (longest * kLongestDepth > kConverged) continue;
    const Cholesky factors(normal->matrix);
    if (!(factors.reciprocal_condition() > 0.0)) break;
    const Eigen::Matrix3d errors = normal->variance() * factors.inverse();
    PlateFit fit{plate,
                 std::sqrt(errors(0, 0)),
                 {std::sqrt(errors(1, 1)), std::sqrt(errors(2, 2))},
                 std::sqrt(normal->residual2 / normal->light2),
                 normal->spots};
    if (fit.misfit <= kMaxMisfit) return fit;
    break;
  }
  return fail(Errc::refused, "array.plate",
              "no depth and shift of the plates explain the spots: check the charge "
              "(sensor.charge), the focus, and that the keys optics.* and array.* are those of the "
              "bench");
}

}  // namespace ovws
