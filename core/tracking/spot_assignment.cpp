#include "core/tracking/spot_assignment.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/cholesky.hpp"

namespace ovws {
namespace {

constexpr double kSeedOffset = 0.5;  // of the extent: outer seeds, in case one side's spots fail
constexpr double kTolerance = 0.35;  // of the pitch, from the expected position
constexpr double kRing = 1.6;        // of the pitch: growth of the field per round
constexpr int kFinalRounds = 2;      // rounds after the last ring
constexpr double kOutlier = 3.0;     // times the median residual
constexpr double kFitSlack = 0.1;    // of the pitch: smaller residuals are never outliers
// Largest element of the linear part. A hexagonal lattice turned by 60 degrees, which looks the
// same, has 0.87; 1 would fold neighbours.
constexpr double kMaxLinear = 0.75;
constexpr double kNeighbour = 1.6;  // of the pitch: largest distance of two neighbours
constexpr int kMinAffine = 4;       // matches needed to fit the linear part
constexpr double kMaxCondition = 100.0;
constexpr int kFewStarts = 16;  // positions tried per seed with a first gradient
// A few spots, in units of the root of the number of subapertures. A lattice shifted by a pitch
// leaves about one such root unexplained; half of it does not make a shift more likely.
constexpr double kFewOfRoot = 0.25;
// Rounds in which a growth is compared with earlier ones, and from which on it is abandoned if it
// explains less than this part of min_share of the subapertures that it has reached.
constexpr int kEarlyRound = 2, kLateRound = 6, kHopelessRound = 4;
constexpr double kHopeless = 0.9;
constexpr std::size_t kMaxGrown = 64;
// First gradients: defocus and astigmatism in two orientations, with both signs.
constexpr double kFirst = 0.3;
constexpr std::array<std::array<double, 4>, 6> kFirstLinear{{{-kFirst, 0.0, 0.0, -kFirst},
                                                             {kFirst, 0.0, 0.0, kFirst},
                                                             {-kFirst, 0.0, 0.0, kFirst},
                                                             {kFirst, 0.0, 0.0, -kFirst},
                                                             {0.0, -kFirst, -kFirst, 0.0},
                                                             {0.0, kFirst, kFirst, 0.0}}};

Vec2 operator*(const std::array<double, 4>& linear, Vec2 p) {
  return {linear[0] * p.x + linear[1] * p.y, linear[2] * p.x + linear[3] * p.y};
}

/// 1-norm.
double norm_of(const Eigen::Matrix3d& matrix) {
  return matrix.cwiseAbs().colwise().sum().maxCoeff();
}

double nearest_distance(const std::vector<Vec2>& points, std::size_t i) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k != i) best = std::min(best, norm(points[k] - points[i]));
  }
  return best;
}

}  // namespace

SpotAssignment::SpotAssignment(std::vector<Vec2> predicted_px, int max_found,
                               std::vector<int> kinds)
    : predicted_(std::move(predicted_px)),
      kinds_(std::move(kinds)),
      matched_(predicted_.size()),
      owner_(std::size_t(max_found)),
      choices_(predicted_.size()),
      residuals_(predicted_.size()),
      sorted_(predicted_.size()),
      best_matched_(predicted_.size()),
      grown_(kMaxGrown, std::vector<int>(predicted_.size())),
      few_(int(kFewOfRoot * std::sqrt(double(predicted_.size())))),
      many_(int(2.0 * kFewOfRoot * std::sqrt(double(predicted_.size())))) {
  by_y_.reserve(owner_.size());
  std::vector<double> distances;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    centre_ = centre_ + (1.0 / double(predicted_.size())) * predicted_[i];
    distances.push_back(nearest_distance(predicted_, i));
  }
  std::sort(distances.begin(), distances.end());
  pitch_ = distances.empty() ? 1.0 : std::max(1.0, distances[distances.size() / 2]);
  for (const Vec2 p : predicted_) extent_ = std::max(extent_, norm(p - centre_));
  find_neighbours();
  find_seeds();
}

void SpotAssignment::find_neighbours() {
  neighbours_.resize(predicted_.size());
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    for (std::size_t k = 0; k < predicted_.size(); ++k) {
      const double distance = norm(predicted_[k] - predicted_[i]);
      if (k != i && distance < kNeighbour * pitch_) neighbours_[i].push_back(int(k));
    }
  }
}

void SpotAssignment::find_seeds() {
  const double offset = kSeedOffset * extent_;
  for (const Vec2 off : {Vec2{}, {0.0, offset}, {0.0, -offset}, {offset, 0.0}, {-offset, 0.0}}) {
    const auto nearest = std::min_element(
        predicted_.begin(), predicted_.end(),
        [at = centre_ + off](Vec2 a, Vec2 b) { return norm(a - at) < norm(b - at); });
    const int seed = int(nearest - predicted_.begin());
    if (std::find(seeds_.begin(), seeds_.end(), seed) == seeds_.end()) seeds_.push_back(seed);
  }
}

double SpotAssignment::tolerance_px() const {
  return kTolerance * pitch_;
}

int SpotAssignment::least_found(const Rules& rules) const OVWS_NONBLOCKING {
  return std::max(3, int(std::ceil(rules.min_share * size())));
}

std::span<const int> SpotAssignment::match(std::span<const Vec2> found, const Rules& rules,
                                           std::span<const int> found_kinds) {
  found_kinds_ = found_kinds;
  growths_ = grown_count_ = 0;
  most_explained_ = 0;
  smallest_shift_ = 0.0;
  std::fill(best_matched_.begin(), best_matched_.end(), int(kNone));
  by_y_.resize(found.size());  // within the reserved capacity
  std::iota(by_y_.begin(), by_y_.end(), 0);
  std::sort(by_y_.begin(), by_y_.end(), [&](int a, int b) { return found[a].y < found[b].y; });
  all_ = int(std::min(found.size(), predicted_.size()));
  match_from(found, rules, {}, kStarts);
  for (const Linear& linear : kFirstLinear) {
    if (most_explained_ == all_ || is_settled()) break;
    match_from(found, rules, linear, kFewStarts);
  }
  return adopt_best(found);
}

/// Whether the best field suffices: it explains all positions but a few, and any other field that
/// differs by half a pitch or more has a larger shift.
bool SpotAssignment::is_settled() const {
  if (most_explained_ == size()) return true;
  return most_explained_ >= all_ - few_ && smallest_shift_ < 0.5 * pitch_;
}

/// Whether a field of this shift is more likely than the best one. Lost spots at the rim let a
/// field shifted by a pitch explain a few more positions if there are spots beyond the lattice, as
/// behind an array of lenslets in wide light. A lattice that has moved explains most of the
/// positions that the other field leaves, or many.
bool SpotAssignment::is_better(int explained, double shift, std::size_t found) const {
  if (most_explained_ == 0) return true;
  const int gain = explained - most_explained_;
  if (std::abs(shift - smallest_shift_) < 0.5 * pitch_) {
    return gain > 0 || (gain == 0 && shift < smallest_shift_);
  }
  const int more = std::abs(gain), left = int(found) - std::min(explained, most_explained_);
  const bool clearly = more > many_ || (more > 0 && 4 * more >= left);
  return clearly ? gain > 0 : shift < smallest_shift_;
}

/// Whether a position may be that of a subaperture's spot.
bool SpotAssignment::of_kind(int subaperture, int position) const {
  return kinds_.empty() || kinds_[std::size_t(subaperture)] == found_kinds_[std::size_t(position)];
}

/// Tries all seeds, each with its nearest positions, with fields that begin with this gradient.
void SpotAssignment::match_from(std::span<const Vec2> found, const Rules& rules,
                                const Linear& linear, int most_starts) {
  const int enough = least_found(rules);
  for (const int seed : seeds_) {
    std::array<int, kStarts> starts{};
    const int count = std::min(nearest_positions(found, seed, starts), most_starts);
    for (int s = 0; s < count; ++s) {
      if (best_matched_[seed] == starts[s]) continue;  // would only repeat the best match
      const Vec2 first_shift = found[starts[s]] - predicted_[seed];
      if (norm(first_shift) > rules.max_shift_px) break;  // starts are sorted by distance
      const int explained =
          grow(found, rules, seed, {first_shift - linear * (predicted_[seed] - centre_), linear});
      const double shift = norm(field_.shift);
      if (explained < enough || !is_better(explained, shift, found.size())) continue;
      most_explained_ = explained;
      smallest_shift_ = shift;
      best_field_ = field_;
      best_matched_ = matched_;  // same size: no allocation
      if (is_settled()) return;
    }
  }
}

std::span<const int> SpotAssignment::adopt_best(std::span<const Vec2> found) {
  field_ = best_field_;
  matched_ = best_matched_;
  update_residuals(found);
  return matched_;
}

/// The positions nearest to the seed's predicted one, of its kind.
int SpotAssignment::nearest_positions(std::span<const Vec2> found, int seed,
                                      std::array<int, kStarts>& out) const {
  const Vec2 at = predicted_[std::size_t(seed)];
  int count = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!of_kind(seed, int(k))) continue;
    int place = count;
    const double distance = norm(found[k] - at);
    while (place > 0 && norm(found[out[place - 1]] - at) > distance) --place;
    if (place == kStarts) continue;
    count = std::min(count + 1, kStarts);
    for (int i = count - 1; i > place; --i) out[i] = out[i - 1];
    out[place] = int(k);
  }
  return count;
}

/// Grows a match from the field `first`. Returns the number of positions that it explains; 0 if it
/// would repeat an earlier one, explains too little, or less than the best one.
int SpotAssignment::grow(std::span<const Vec2> found, const Rules& rules, int seed, Field first) {
  ++growths_;
  field_ = first;
  std::fill(matched_.begin(), matched_.end(), int(kNone));
  std::fill(residuals_.begin(), residuals_.end(), Vec2{});
  const Vec2 from = predicted_[seed];
  const double whole = extent_ + norm(from - centre_);
  const int rings = int(std::ceil(whole / (kRing * pitch_)));
  int count = 0;
  for (int round = 1; round <= rings + kFinalRounds; ++round) {
    count = assign(found, from, round * kRing * pitch_);
    if (count == 0 || !fit(found)) return 0;
    update_residuals(found);
    if (round >= kEarlyRound && round <= kLateRound && repeats(count)) return 0;
    if (round < kHopelessRound) continue;
    if (count < kHopeless * rules.min_share * reached_) return 0;
    if (count + size() - reached_ + many_ < most_explained_) {
      count = 0;
      break;
    }
  }
  if (std::size_t(grown_count_) < grown_.size()) grown_[std::size_t(grown_count_++)] = matched_;
  return count;
}

/// Whether an earlier growth has all matches that this one has so far.
bool SpotAssignment::repeats(int count) const {
  if (count < kMinAffine) return false;
  return std::any_of(grown_.begin(), grown_.begin() + grown_count_, [&](const auto& before) {
    for (std::size_t i = 0; i < matched_.size(); ++i) {
      if (matched_[i] != kNone && matched_[i] != before[i]) return false;
    }
    return true;
  });
}

Vec2 SpotAssignment::affine(int i) const {
  return predicted_[i] + field_.shift + field_.linear * (predicted_[i] - centre_);
}

Vec2 SpotAssignment::expected(int i) const {
  Vec2 sum;
  int count = 0;
  for (const int k : neighbours_[i]) {
    if (matched_[k] == kNone) continue;
    sum = sum + residuals_[k];
    ++count;
  }
  return count == 0 ? affine(i) : affine(i) + (1.0 / count) * sum;
}

void SpotAssignment::update_residuals(std::span<const Vec2> found) {
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    residuals_[i] = matched_[i] == kNone ? Vec2{} : found[matched_[i]] - affine(int(i));
  }
}

/// The position nearest to the expected one of subaperture i, within the tolerance.
SpotAssignment::Choice SpotAssignment::nearest(std::span<const Vec2> found, int i) const {
  const Vec2 at = expected(i);
  Choice best{kNone, tolerance_px()};
  const auto first = std::lower_bound(by_y_.begin(), by_y_.end(), at.y - best.distance,
                                      [&](int k, double y) { return found[std::size_t(k)].y < y; });
  for (auto k = first; k != by_y_.end() && found[*k].y < at.y + tolerance_px(); ++k) {
    if (std::abs(found[*k].x - at.x) >= best.distance) continue;
    const double distance = norm(found[*k] - at);
    if (distance < best.distance && of_kind(i, *k)) best = {*k, distance};
  }
  return best;
}

/// Assigns to each subaperture within `reach` of `from` the nearest position within the tolerance.
/// A position chosen by two subapertures goes to the nearer one; the farther one gets none.
int SpotAssignment::assign(std::span<const Vec2> found, Vec2 from, double reach) {
  std::fill(owner_.begin(), owner_.end(), int(kNone));
  reached_ = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    choices_[i] = {};
    if (norm(predicted_[i] - from) > reach) continue;
    ++reached_;
    choices_[i] = nearest(found, int(i));
    if (choices_[i].position == kNone) continue;
    int& owner = owner_[choices_[i].position];
    if (owner == kNone || choices_[i].distance < choices_[owner].distance) owner = int(i);
  }
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    const int k = choices_[i].position;
    matched_[i] = k != kNone && owner_[k] == int(i) ? k : kNone;
    count += matched_[i] != kNone ? 1 : 0;
  }
  return count;
}

/// Fits the displacement field to all matches, then again without outliers. False if it fails.
bool SpotAssignment::fit(std::span<const Vec2> found) {
  if (!fit_within(found, std::numeric_limits<double>::infinity())) return false;
  update_residuals(found);
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    if (matched_[i] != kNone) sorted_[count++] = norm(residuals_[i]);
  }
  std::nth_element(sorted_.begin(), sorted_.begin() + count / 2, sorted_.begin() + count);
  return fit_within(found, std::max(kFitSlack * pitch_, kOutlier * sorted_[count / 2]));
}

bool SpotAssignment::fit_within(std::span<const Vec2> found, double limit) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> rhs = Eigen::Matrix<double, 3, 2>::Zero();
  int count = 0;
  for (std::size_t i = 0; i < predicted_.size(); ++i) {
    const bool outlier = std::isfinite(limit) && norm(residuals_[i]) > limit;
    if (matched_[i] == kNone || outlier) continue;
    const Vec2 p = (1.0 / pitch_) * (predicted_[i] - centre_);
    const Vec2 d = found[matched_[i]] - predicted_[i];
    const Eigen::Vector3d basis(1.0, p.x, p.y);
    normal += basis * basis.transpose();
    rhs += basis * Eigen::RowVector2d(d.x, d.y);
    ++count;
  }
  if (count == 0) return false;
  // Too few or collinear spots do not determine the linear part: it stays.
  const Vec2 moved{rhs(0, 0) / count, rhs(0, 1) / count};
  const Vec2 middle{normal(0, 1) / count, normal(0, 2) / count};
  field_.shift = moved - field_.linear * (pitch_ * middle);
  Eigen::Matrix3d inverse = normal;
  if (count < kMinAffine || !invert_positive(inverse)) return true;
  if (norm_of(normal) * norm_of(inverse) > kMaxCondition) return true;
  const Eigen::Matrix<double, 3, 2> a = inverse * rhs;
  field_.shift = {a(0, 0), a(0, 1)};
  field_.linear = {a(1, 0) / pitch_, a(2, 0) / pitch_, a(1, 1) / pitch_, a(2, 1) / pitch_};
  return std::all_of(field_.linear.begin(), field_.linear.end(),
                     [](double v) { return std::abs(v) < kMaxLinear; });
}

}  // namespace ovws
