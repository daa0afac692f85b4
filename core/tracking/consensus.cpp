#include "core/tracking/consensus.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ovws {
namespace {

constexpr int kVotesPerPitch = 4;
constexpr int kRounds = 8;
constexpr double kTolerance = 0.35;  // of the pitch, from the expected position
constexpr double kOutlier = 3.0;     // times the median residual
constexpr double kFitSlack = 0.1;    // of the pitch: residuals below are never outliers
constexpr double kMaxLinear = 0.6;   // 1 would fold neighbours onto each other
constexpr double kNeighbour = 1.6;   // of the nearest neighbour's distance
constexpr int kMinAffine = 4;        // matches that a linear map needs at least
constexpr double kMinRcond = 0.01;

double nearest_distance(const std::vector<Vec2>& points, std::size_t i) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k != i) best = std::min(best, norm(points[k] - points[i]));
  }
  return best;
}

}  // namespace

Consensus::Consensus(std::vector<Vec2> predicted_px, int max_found)
    : predicted_(std::move(predicted_px)),
      votes_((2 * kVoteHalf + 1) * (2 * kVoteHalf + 1)),
      matched_(predicted_.size()),
      owner_(std::size_t(max_found)),
      choices_(predicted_.size()),
      residuals_(predicted_.size()),
      sorted_(predicted_.size()),
      best_matched_(predicted_.size()) {
  for (const Vec2 p : predicted_) centre_ = centre_ + (1.0 / double(predicted_.size())) * p;
  std::vector<double> distances;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    distances.push_back(nearest_distance(predicted_, i));
  }
  std::sort(distances.begin(), distances.end());
  pitch_ = distances.empty() ? 1.0 : std::max(1.0, distances[distances.size() / 2]);
  find_neighbours();
}

void Consensus::find_neighbours() {
  neighbours_.resize(predicted_.size());
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    for (std::size_t k = 0; k < predicted_.size(); ++k) {
      const double distance = norm(predicted_[k] - predicted_[i]);
      if (k != i && distance < kNeighbour * pitch_) neighbours_[i].push_back(int(k));
    }
  }
}

double Consensus::tolerance_px() const {
  return kTolerance * pitch_;
}

std::span<const int> Consensus::match(std::span<const Vec2> found) {
  const int enough = std::max(3, int(predicted_.size() + 2) / 3);
  int most = 0;
  double least_shift = 0.0;
  std::fill(best_matched_.begin(), best_matched_.end(), int(kNone));
  vote(found);
  for (int h = 0; h < kHypotheses; ++h) {
    const int count = grow(found, best_shift());
    const double shift = norm(field_.shift);
    if (count < enough || count < most || (count == most && shift >= least_shift)) continue;
    most = count;
    least_shift = shift;
    best_field_ = field_;
    best_matched_ = matched_;  // same size: no allocation
  }
  field_ = best_field_;
  matched_ = best_matched_;
  note_residuals(found);
  return matched_;
}

void Consensus::vote(std::span<const Vec2> found) {
  std::fill(votes_.begin(), votes_.end(), 0);
  const double per_px = kVotesPerPitch / pitch_;
  for (const Vec2 p : predicted_) {
    for (const Vec2 f : found) {
      const int x = int(std::lround((f.x - p.x) * per_px));
      const int y = int(std::lround((f.y - p.y) * per_px));
      if (std::abs(x) > kVoteHalf || std::abs(y) > kVoteHalf) continue;
      ++votes_[(y + kVoteHalf) * (2 * kVoteHalf + 1) + x + kVoteHalf];
    }
  }
}

/// The cell with most votes in it and (by half and by a quarter) around it, the nearest to no shift
/// among equals; its neighbourhood is then taken out.
Vec2 Consensus::best_shift() {
  constexpr int kSide = 2 * kVoteHalf + 1;
  int most = 0, best_x = 0, best_y = 0;
  for (int y = 1 - kVoteHalf; y < kVoteHalf; ++y) {
    for (int x = 1 - kVoteHalf; x < kVoteHalf; ++x) {
      const int* v = &votes_[(y + kVoteHalf) * kSide + x + kVoteHalf];
      int sum = 0;
      for (const int row : {-kSide, 0, 0, kSide}) sum += v[row - 1] + 2 * v[row] + v[row + 1];
      const bool nearer = x * x + y * y < best_x * best_x + best_y * best_y;
      if (sum > most || (sum == most && sum > 0 && nearer)) {
        most = sum;
        best_x = x;
        best_y = y;
      }
    }
  }
  int* v = &votes_[(best_y + kVoteHalf) * kSide + best_x + kVoteHalf];
  if (most > 0) {
    for (const int row : {-kSide, 0, kSide}) v[row - 1] = v[row] = v[row + 1] = 0;
  }
  return {best_x * pitch_ / kVotesPerPitch, best_y * pitch_ / kVotesPerPitch};
}

int Consensus::grow(std::span<const Vec2> found, Vec2 shift) {
  field_ = {shift, {}};
  std::fill(matched_.begin(), matched_.end(), int(kNone));
  std::fill(residuals_.begin(), residuals_.end(), Vec2{});
  int count = 0;
  for (int round = 0; round < kRounds; ++round) {
    count = assign(found);
    if (count < 3 || !fit(found)) return 0;
    note_residuals(found);
  }
  return count;
}

Vec2 Consensus::affine(int i) const {
  const Vec2 p = predicted_[i] - centre_;
  const auto& a = field_.linear;
  return predicted_[i] + field_.shift + Vec2{a[0] * p.x + a[1] * p.y, a[2] * p.x + a[3] * p.y};
}

Vec2 Consensus::expected(int i) const {
  Vec2 sum;
  int count = 0;
  for (const int k : neighbours_[i]) {
    if (matched_[k] == kNone) continue;
    sum = sum + residuals_[k];
    ++count;
  }
  return count == 0 ? affine(i) : affine(i) + (1.0 / count) * sum;
}

void Consensus::note_residuals(std::span<const Vec2> found) {
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    residuals_[i] = matched_[i] == kNone ? Vec2{} : found[matched_[i]] - affine(int(i));
  }
}

/// Each subaperture chooses the nearest position within the tolerance; a position chosen twice goes
/// to the nearer one, and the other goes without.
int Consensus::assign(std::span<const Vec2> found) {
  std::fill(owner_.begin(), owner_.end(), int(kNone));
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    const Vec2 at = expected(int(i));
    Choice& choice = choices_[i] = {kNone, tolerance_px()};
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double distance = norm(found[k] - at);
      if (distance < choice.distance) choice = {int(k), distance};
    }
    if (choice.position == kNone) continue;
    int& owner = owner_[choice.position];
    if (owner == kNone || choice.distance < choices_[owner].distance) owner = int(i);
  }
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    const int k = choices_[i].position;
    matched_[i] = k != kNone && owner_[k] == int(i) ? k : kNone;
    count += matched_[i] != kNone ? 1 : 0;
  }
  return count;
}

/// Fits all matches, then once more without those that do not go with the rest.
bool Consensus::fit(std::span<const Vec2> found) {
  if (!fit_within(found, std::numeric_limits<double>::infinity())) return false;
  note_residuals(found);
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    if (matched_[i] != kNone) sorted_[count++] = norm(residuals_[i]);
  }
  std::nth_element(sorted_.begin(), sorted_.begin() + count / 2, sorted_.begin() + count);
  return fit_within(found, std::max(kFitSlack * pitch_, kOutlier * sorted_[count / 2]));
}

bool Consensus::fit_within(std::span<const Vec2> found, double limit) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> rhs = Eigen::Matrix<double, 3, 2>::Zero();
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    const bool outlier =
        limit < std::numeric_limits<double>::infinity() && norm(residuals_[i]) > limit;
    if (matched_[i] == kNone || outlier) continue;
    const Vec2 p = (1.0 / pitch_) * (predicted_[i] - centre_);
    const Vec2 d = found[matched_[i]] - predicted_[i];
    const Eigen::Vector3d basis(1.0, p.x, p.y);
    normal += basis * basis.transpose();
    rhs += basis * Eigen::RowVector2d(d.x, d.y);
    ++count;
  }
  if (count == 0) return false;
  field_ = {{rhs(0, 0) / count, rhs(0, 1) / count}, {}};
  // Few spots, or spots along one line, say nothing about a linear map.
  const Eigen::LLT<Eigen::Matrix3d> llt(normal);
  if (count < kMinAffine || llt.info() != Eigen::Success || llt.rcond() < kMinRcond) return true;
  const Eigen::Matrix<double, 3, 2> a = llt.solve(rhs);
  field_.shift = {a(0, 0), a(0, 1)};
  field_.linear = {a(1, 0) / pitch_, a(2, 0) / pitch_, a(1, 1) / pitch_, a(2, 1) / pitch_};
  return std::all_of(field_.linear.begin(), field_.linear.end(),
                     [](double v) { return std::abs(v) < kMaxLinear; });
}

}  // namespace ovws
