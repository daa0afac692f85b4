#include "core/wavefront/matrix_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/decompositions.hpp"
#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

constexpr double kAlike = 0.9;   // correlation of columns that are equal up to a factor, at least
constexpr double kUnlike = 0.5;  // correlation of different columns, at most
constexpr double kMaxRotationDeg = 1.0;  // rotation that still counts as agreement
constexpr double kMaxScaleError = 0.03;  // deviation of the common scale from 1
constexpr double kMaxFactorError = 0.2;  // deviation of one column from the common scale
constexpr std::size_t kMaxListed = 3;    // modes listed in one message

const char* const kRegister = "run registration.run, then reference.take and calibration.run";

/// Columns of the modes that measurement and model have in common, for the spots in use.
struct Pair {
  std::vector<int> modes_j;
  Eigen::MatrixXd measured, error, model;
  Eigen::MatrixXd all_model;     ///< every column of the model
  std::vector<int> all_modes_j;  ///< OSA indices of the columns of all_model
};

Eigen::MatrixXd picked(const Eigen::MatrixXd& all, const std::vector<Eigen::Index>& rows,
                       const std::vector<Eigen::Index>& columns) {
  Eigen::MatrixXd out(Eigen::Index(rows.size()), Eigen::Index(columns.size()));
  for (Eigen::Index c = 0; c < out.cols(); ++c) {
    for (Eigen::Index r = 0; r < out.rows(); ++r) {
      out(r, c) = all(rows[std::size_t(r)], columns[std::size_t(c)]);
    }
  }
  return out;
}

Pair pair_of(const InteractionMatrix& measured, const ModeOperator& model) {
  std::vector<Eigen::Index> rows, from, to, all(model.modes_j.size());
  std::iota(all.begin(), all.end(), 0);
  for (Eigen::Index i = 0; i < measured.spots(); ++i) {
    const auto& lost = measured.lost_spots;
    if (std::find(lost.begin(), lost.end(), int(i)) != lost.end()) continue;
    rows.push_back(2 * i);
    rows.push_back(2 * i + 1);
  }
  Pair pair;
  for (std::size_t k = 0; k < measured.modes_j.size(); ++k) {
    const auto at = std::find(model.modes_j.begin(), model.modes_j.end(), measured.modes_j[k]);
    if (at == model.modes_j.end()) continue;
    pair.modes_j.push_back(measured.modes_j[k]);
    from.push_back(Eigen::Index(k));
    to.push_back(at - model.modes_j.begin());
  }
  pair.measured = picked(measured.slopes, rows, from);
  pair.error = picked(measured.standard_error, rows, from);
  pair.model = picked(model.slopes, rows, to);
  pair.all_model = picked(model.slopes, rows, all);
  pair.all_modes_j = model.modes_j;
  return pair;
}

double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const double norms = a.norm() * b.norm();
  return norms > 0.0 ? a.dot(b) / norms : 0.0;
}

std::vector<ModeComparison> compare_modes(const Pair& pair) {
  std::vector<ModeComparison> modes;
  for (std::size_t n = 0; n < pair.modes_j.size(); ++n) {
    const auto k = Eigen::Index(n);
    const Eigen::VectorXd m = pair.measured.col(k), s = pair.model.col(k);
    const double squares = std::max(s.squaredNorm(), 1e-300);
    modes.push_back({pair.modes_j[n], m.dot(s) / squares,
                     s.cwiseProduct(pair.error.col(k)).norm() / squares, correlation(m, s)});
  }
  return modes;
}

/// Least-squares 2 x 2 map from the model's displacements to the measured ones, with equal weight
/// for every mode.
Eigen::Matrix2d best_map(const Pair& pair) {
  Eigen::Matrix2d ms = Eigen::Matrix2d::Zero(), ss = Eigen::Matrix2d::Zero();
  for (Eigen::Index k = 0; k < pair.model.cols(); ++k) {
    const double weight = 1.0 / std::max(pair.model.col(k).squaredNorm(), 1e-300);
    for (Eigen::Index i = 0; i < pair.model.rows(); i += 2) {
      const Eigen::Vector2d m = pair.measured.block<2, 1>(i, k), s = pair.model.block<2, 1>(i, k);
      ms += weight * m * s.transpose();
      ss += weight * s * s.transpose();
    }
  }
  const Eigen::MatrixXd transposed = least_squares(ss, Eigen::MatrixXd(ms.transpose()));
  return transposed.transpose();
}

bool explains(const Eigen::Matrix2d& map, const Pair& pair) {
  for (Eigen::Index k = 0; k < pair.model.cols(); ++k) {
    Eigen::VectorXd mapped = pair.model.col(k);
    for (Eigen::Index i = 0; i < mapped.size(); i += 2) {
      mapped.segment<2>(i) = (map * mapped.segment<2>(i)).eval();
    }
    if (correlation(mapped, pair.measured.col(k)) < kAlike) return false;
  }
  return true;
}

std::string listed(const std::vector<std::string>& all) {
  std::string out;
  for (std::size_t i = 0; i < std::min(kMaxListed, all.size()); ++i) {
    out += (i == 0 ? "" : ", ") + all[i];
  }
  return all.size() > kMaxListed ? out + " and " + std::to_string(all.size() - kMaxListed) + " more"
                                 : out;
}

struct Finding {
  Disagreement kind = Disagreement::none;
  std::string words;
};

/// 2 x 2 maps of exchanged, mirrored or rotated axes that the diagnosis distinguishes.
struct Exchange {
  Disagreement kind;
  double xx, xy, yx, yy;
  const char* words;
};
constexpr std::array<Exchange, 8> kExchanges{{
    {Disagreement::none, 1, 0, 0, 1, ""},
    {Disagreement::sign, -1, 0, 0, -1, "every displacement has the wrong sign"},
    {Disagreement::sign, -1, 0, 0, 1, "displacements along x have the wrong sign"},
    {Disagreement::sign, 1, 0, 0, -1, "displacements along y have the wrong sign"},
    {Disagreement::axes, 0, 1, 1, 0, "the axes x and y are exchanged"},
    {Disagreement::axes, 0, -1, -1, 0,
     "the axes x and y are exchanged, and both have the wrong sign"},
    {Disagreement::rotation, 0, -1, 1, 0, "displacements are rotated by 90 degrees"},
    {Disagreement::rotation, 0, 1, -1, 0, "displacements are rotated by -90 degrees"},
}};

/// Looks for single columns, or a common scale, that differ from the model.
Finding judge_factors(const std::vector<ModeComparison>& modes, double scale) {
  std::vector<std::string> odd;
  for (const ModeComparison& mode : modes) {
    if (std::abs(mode.factor / scale - 1.0) > kMaxFactorError) {
      odd.push_back("j = " + std::to_string(mode.j) + " by " + with_decimals(mode.factor, 2));
    }
  }
  if (!odd.empty()) {
    return {Disagreement::single_modes,
            "some modes move the spots by another factor than in the model: " + listed(odd) +
                "; check that the illumination is even, and that no spot is split"};
  }
  if (std::abs(scale - 1.0) <= kMaxScaleError) return {};
  return {Disagreement::scale,
          "every displacement is " + with_decimals(scale, 3) +
              " times the model's: the magnification or the focal length is not the configured "
              "one; " +
              kRegister};
}

Finding judge_map(const Eigen::Matrix2d& map, const std::vector<ModeComparison>& modes) {
  const double scale = std::sqrt(std::abs(map(0, 0) * map(1, 1) - map(0, 1) * map(1, 0)));
  const Exchange* nearest = kExchanges.data();
  double best_similarity = -1e300;
  for (const Exchange& e : kExchanges) {
    const double similarity =
        e.xx * map(0, 0) + e.xy * map(0, 1) + e.yx * map(1, 0) + e.yy * map(1, 1);
    if (similarity > best_similarity) nearest = &e;
    best_similarity = std::max(best_similarity, similarity);
  }
  if (nearest->kind != Disagreement::none) {
    return {nearest->kind, std::string(nearest->words) +
                               ": the camera's orientation is not the configured one; " +
                               kRegister};
  }
  const double rotation_deg =
      std::atan2(map(1, 0) - map(0, 1), map(0, 0) + map(1, 1)) * 180.0 / std::numbers::pi;
  if (std::abs(rotation_deg) > kMaxRotationDeg) {
    return {Disagreement::rotation,
            "displacements are rotated by " + with_decimals(rotation_deg, 1) +
                " degrees: the camera's orientation is not the configured one; " + kRegister};
  }
  return judge_factors(modes, scale);
}

/// Parity check: a mirrored lattice looks unchanged, but inverts the modes that are odd under the
/// mirroring.
Finding judge_signs(const std::vector<ModeComparison>& modes) {
  struct Mirror {
    Vec2 by;
    const char* words;
  };
  constexpr std::array<Mirror, 3> kMirrors{{{{-1, 1}, "mirrored along x"},
                                            {{1, -1}, "mirrored along y"},
                                            {{-1, -1}, "rotated by 180 degrees"}}};
  constexpr Vec2 kAt{0.31, 0.57};  // on no symmetry axis of any mode
  for (const Mirror& mirror : kMirrors) {
    const Vec2 mirrored{mirror.by.x * kAt.x, mirror.by.y * kAt.y};
    const bool fits = std::all_of(modes.begin(), modes.end(), [&](const ModeComparison& mode) {
      const bool odd = zernike(mode.j, kAt) * zernike(mode.j, mirrored) < 0.0;
      return odd == (mode.factor < 0.0);
    });
    if (fits) {
      return {Disagreement::parity, std::string("the modes that change sign in an image ") +
                                        mirror.words +
                                        " have the wrong sign: the camera sees the lattice " +
                                        mirror.words + "; " + kRegister};
    }
  }
  std::vector<std::string> wrong;
  for (const ModeComparison& mode : modes) {
    if (mode.factor < 0.0) wrong.push_back("j = " + std::to_string(mode.j));
  }
  return {Disagreement::sign, "single modes have the wrong sign: " + listed(wrong) +
                                  "; the SLM and the model define them differently"};
}

Finding judge_order(const Pair& pair, const std::vector<ModeComparison>& modes) {
  std::vector<std::string> others;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (std::abs(modes[k].correlation) > kUnlike) continue;
    for (std::size_t l = 0; l < pair.all_modes_j.size(); ++l) {
      const double similarity =
          correlation(pair.measured.col(Eigen::Index(k)), pair.all_model.col(Eigen::Index(l)));
      if (std::abs(similarity) < kAlike) continue;
      others.push_back("j = " + std::to_string(modes[k].j) +
                       " looks like the model's j = " + std::to_string(pair.all_modes_j[l]) +
                       (similarity < 0.0 ? " with the wrong sign" : ""));
    }
  }
  if (!others.empty()) {
    return {Disagreement::order, "the modes are in another order: " + listed(others) +
                                     "; check that no other program changes what the SLM shows, "
                                     "then repeat calibration.run"};
  }
  return {
      Disagreement::unlike,
      std::string("the spots do not move as the model says, nor as it would rotated, mirrored or "
                  "with the modes in another order: check that the spots are found and assigned to "
                  "the right subapertures; ") +
          kRegister};
}

Finding judge(const Pair& pair, const std::vector<ModeComparison>& modes) {
  if (modes.empty()) return {};
  const Eigen::Matrix2d map = best_map(pair);
  if (explains(map, pair)) return judge_map(map, modes);
  const bool alike = std::all_of(modes.begin(), modes.end(), [](const ModeComparison& mode) {
    return std::abs(mode.correlation) >= kAlike;
  });
  return alike ? judge_signs(modes) : judge_order(pair, modes);
}

}  // namespace

MatrixComparison compare(const InteractionMatrix& measured, const ModeOperator& model) {
  const Pair pair = pair_of(measured, model);
  MatrixComparison comparison;
  comparison.modes = compare_modes(pair);
  Finding found = judge(pair, comparison.modes);
  comparison.disagreement = found.kind;
  comparison.words = std::move(found.words);
  return comparison;
}

}  // namespace ovws
