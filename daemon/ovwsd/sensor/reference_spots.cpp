#include "daemon/ovwsd/sensor/reference_spots.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <limits>

#include "core/base/decompositions.hpp"
#include "core/pipeline/neighbourhood.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {
namespace {

/// Relative standard deviation of each mode, if all spots have equal noise. Empty: the spots do not
/// determine all modes.
Eigen::VectorXd noise_of_modes(const Eigen::MatrixXd& slopes) {
  if (determined_modes(slopes) != int(slopes.cols())) return {};
  return Cholesky(gram_matrix(slopes)).inverse().diagonal().cwiseSqrt();
}

struct Growth {
  std::vector<int> weak_j, undetermined_j;
};

Growth growth_without(const std::vector<int>& lost, const ModeOperator& modes) {
  Eigen::MatrixXd left = modes.slopes;
  for (const int i : lost) left.middleRows(2 * Eigen::Index(i), 2).setZero();
  const Eigen::VectorXd all = noise_of_modes(modes.slopes), some = noise_of_modes(left);
  if (some.size() == 0) return {{}, modes.modes_j};
  Growth growth;
  for (Eigen::Index k = 0; k < some.size(); ++k) {
    const double by = all.size() > 0 ? some[k] / all[k] : 1.0;
    const int j = modes.modes_j[std::size_t(k)];
    if (by > Reconstructor::kMaxNoiseGrowth) growth.undetermined_j.push_back(j);
    if (by > kWeakGrowth) growth.weak_j.push_back(j);
  }
  return growth;
}

/// The nearest of the other places, and its number.
std::size_t nearest_other(const std::vector<Vec2>& places, std::size_t of) {
  std::size_t nearest = of;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double away = norm(places[k] - places[of]);
    if (k == of || away >= least) continue;
    least = away;
    nearest = k;
  }
  return nearest;
}

}  // namespace

Result<ReferenceSpots> judge_spots(const SpotAverage& average, const ModeOperator& modes) {
  ReferenceSpots spots;
  for (std::size_t i = 0; i < average.found.size(); ++i) {
    const int found = average.found[i];
    const bool lost = 2 * found < average.frames || (found < 2 && average.frames > 1);
    if (lost) {
      spots.lost.push_back(int(i));
    } else if (10 * found < 9 * average.frames) {
      spots.weak.push_back(int(i));
    }
  }
  if (spots.lost.empty()) return spots;
  Growth growth = growth_without(spots.lost, modes);
  spots.weak_modes_j = std::move(growth.weak_j);
  if (growth.undetermined_j.empty()) return spots;
  return fail(
      Errc::refused, "",
      fmt::format("spots {} were found in fewer than half of the frames, and without them "
                  "the modes j = {} are not determined: check the illumination of the whole "
                  "pupil, the exposure, and that the region of interest contains the "
                  "spots; or use fewer subapertures",
                  listed_spots(spots.lost), listed_spots(growth.undetermined_j)));
}

Result<void> check_order(const SpotAverage& given, const std::vector<Vec2>& model) {
  constexpr double kLeastPart = 0.25;  // of their distance in the model
  for (std::size_t i = 0; i < model.size(); ++i) {
    const std::size_t k = nearest_other(model, i);
    if (given.found[i] == 0 || given.found[k] == 0) continue;
    const Vec2 due = model[k] - model[i], is = given.mean_px[k] - given.mean_px[i];
    if (is.x * due.x + is.y * due.y > kLeastPart * (due.x * due.x + due.y * due.y)) continue;
    return fail(Errc::invalid, "positions",
                fmt::format("spots {} and {} do not lie beside each other as in the lattice: send "
                            "the spots in the order of reference.get",
                            i, k));
  }
  return {};
}

void place_lost(const std::vector<int>& lost, const std::vector<Vec2>& model_px,
                Reference& reference) {
  if (lost.empty()) return;
  std::vector<SpotFix> spots;
  for (const Vec2 at : reference.positions_px) spots.push_back({float(at.x), float(at.y)});
  for (const int i : lost) spots[std::size_t(i)] = {};
  const Neighbourhood neighbourhood(model_px);
  const DisplacementField field = neighbourhood.fit(spots);
  for (const int i : lost) {
    reference.positions_px[std::size_t(i)] = neighbourhood.expect(i, field, spots);
    reference.standard_error_px[std::size_t(i)] = {NAN, NAN};
  }
}

std::vector<Vec2> known_positions(const Reference& reference) {
  std::vector<Vec2> positions = reference.positions_px;
  if (reference.standard_error_px.size() != positions.size()) return positions;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec2& error = reference.standard_error_px[i];
    if (std::isnan(error.x) || std::isnan(error.y)) positions[i] = {NAN, NAN};
  }
  return positions;
}

}  // namespace ovws
