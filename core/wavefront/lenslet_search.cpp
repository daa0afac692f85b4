#include "core/wavefront/lenslet_search.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "core/base/number_text.hpp"
#include "core/optics/lattice.hpp"
#include "core/tracking/candidates.hpp"
#include "core/wavefront/registration.hpp"

namespace ovws {
namespace {

using Complex = std::complex<double>;
using GridIndex = std::pair<int, int>;

constexpr int kMaxSpots = kMaxSubapertures + kMaxSubapertures / 4;
constexpr double kCapture = 0.35;  // of the pitch: largest distance from the expected place
constexpr double kMinOrder = 0.5;  // share of neighbours that lie in the lattice's directions
constexpr double kMinIndexed = 0.6;
// A pupil is often a whole number of pitches, with lenslets just inside: noise does not drop them.
constexpr double kAtRim = 0.02;
// A lenslet with this share of the light of those around it counts in full, and with the share
// kNone of that not at all.
constexpr double kWhole = 0.5, kNone = 0.2;
// Fewer of those around it may be brighter: beside a step of the light, three of eight are.
constexpr double kAround = 0.4;

struct Spot {
  Vec2 at_px;
  double level = 0.0;
};

Complex complex_of(Vec2 at) {
  return {at.x, at.y};
}

/// The lattice's second direction and its neighbours, for a first direction of 1.
struct Directions {
  int symmetry;  ///< directions of the nearest neighbours
  Complex second;
  std::vector<GridIndex> neighbours;
};
Directions directions_of(Grid grid) {
  if (grid == Grid::square) return {4, {0.0, 1.0}, {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  return {6,
          std::polar(1.0, std::numbers::pi / 3.0),
          {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};
}

std::vector<Spot> spots_in(const Image<std::uint16_t>& image, const SpotModel& model) {
  const ImageView view = view_of(image, PixelFormat::mono16);
  const auto tracker = make_tracker({.tracker = TrackerKind::lg}, model);
  if (!tracker) return {};
  TrackScratch scratch = (*tracker)->make_scratch();
  CandidateFinder finder(model, image.width, image.height, {.elsewhere = kMaxSpots});
  std::vector<Spot> spots;
  for (const Vec2 start : finder.find(view, {})) {
    const SpotFix fix = (*tracker)->track(view, start, scratch);
    if (fix.found()) spots.push_back({{double(fix.x), double(fix.y)}, double(fix.level)});
  }
  return spots;
}

/// The value that `part` of the others exceed.
double upper_quantile(std::vector<double> values, double part) {
  const auto at = values.begin() + std::ptrdiff_t(part * double(values.size()));
  std::nth_element(values.begin(), at, values.end(), std::greater<>());
  return *at;
}

/// Drops dark spots, by their level relative to the upper quartile.
void drop_dark(std::vector<Spot>& spots) {
  if (spots.empty()) return;
  std::vector<double> levels;
  for (const Spot& spot : spots) levels.push_back(spot.level);
  const double typical = upper_quantile(std::move(levels), 0.25);
  std::erase_if(spots, [&](const Spot& spot) { return !(spot.level >= kLitLevel * typical); });
}

/// The spots, sorted into square cells, to find the one nearest to a place.
class Nearest {
 public:
  Nearest(const std::vector<Spot>& spots, double cell_px) : spots_(spots), cell_px_(cell_px) {
    for (std::size_t i = 0; i < spots.size(); ++i)
      cells_[cell_of(spots[i].at_px)].push_back(int(i));
  }
  /// Number of the spot nearest to `at`, other than `but`, within one cell; -1: there is none.
  int to(Vec2 at, int but = -1) const {
    int nearest = -1;
    double least = cell_px_;
    const GridIndex middle = cell_of(at);
    for (int k = 0; k < 9; ++k) {
      const auto cell = cells_.find({middle.first + k % 3 - 1, middle.second + k / 3 - 1});
      if (cell == cells_.end()) continue;
      for (const int i : cell->second) {
        const double away = norm(spots_[std::size_t(i)].at_px - at);
        if (i == but || !(away < least)) continue;
        least = away;
        nearest = i;
      }
    }
    return nearest;
  }

 private:
  GridIndex cell_of(Vec2 at) const {
    return {int(std::floor(at.x / cell_px_)), int(std::floor(at.y / cell_px_))};
  }
  const std::vector<Spot>& spots_;
  double cell_px_;
  std::map<GridIndex, std::vector<int>> cells_;
};

/// First direction of the lattice: its length is the median distance of nearest neighbours, its
/// angle their mean angle modulo the symmetry. `order`: 1 if all angles agree, 0 if they are
/// random.
struct FirstDirection {
  Complex step;
  double order = 0.0;
};
FirstDirection first_direction(const std::vector<Spot>& spots, double reach_px, int symmetry) {
  const Nearest nearest(spots, reach_px);
  std::vector<double> lengths;
  Complex sum = 0.0;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const int other = nearest.to(spots[i].at_px, int(i));
    if (other < 0) continue;
    const Complex step = complex_of(spots[std::size_t(other)].at_px - spots[i].at_px);
    lengths.push_back(std::abs(step));
    sum += std::polar(1.0, symmetry * std::arg(step));
  }
  if (lengths.empty()) return {};
  const auto middle = lengths.begin() + std::ptrdiff_t(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return {std::polar(*middle, std::arg(sum) / symmetry), std::abs(sum) / double(lengths.size())};
}

/// Affine map of rotation and scale: place = origin + step (a + b second).
struct LatticeFit {
  Complex origin, step;
  double residual_px = 0.0;
  double step_error_px = 0.0;  ///< standard error of both parts of `step`

  Vec2 at(GridIndex index, Complex second) const {
    const Complex place = origin + step * (double(index.first) + double(index.second) * second);
    return {place.real(), place.imag()};
  }
};

class Indexing {
 public:
  Indexing(const std::vector<Spot>& spots, const Directions& directions, Complex step)
      : spots_(spots), directions_(directions), nearest_(spots, std::abs(step)), step_(step) {}

  /// Numbers the spots from neighbour to neighbour, then those beyond gaps by the fitted lattice.
  void run() {
    std::deque<GridIndex> open{{0, 0}};
    spot_at_[{0, 0}] = middle_spot();
    taken_.assign(spots_.size(), false);
    taken_[std::size_t(spot_at_[{0, 0}])] = true;
    while (!open.empty()) {
      const GridIndex from = open.front();
      open.pop_front();
      const Complex at = complex_of(spots_[std::size_t(spot_at_[from])].at_px);
      for (const GridIndex& next : directions_.neighbours) {
        const GridIndex index{from.first + next.first, from.second + next.second};
        if (!spot_at_.contains(index) && take(index, at + step_ * offset(next))) {
          open.push_back(index);
        }
      }
    }
    const LatticeFit found = fit();
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      if (taken_[i]) continue;
      const Complex place = (complex_of(spots_[i].at_px) - found.origin) / found.step;
      const double b = place.imag() / directions_.second.imag();
      const GridIndex index{int(std::lround(place.real() - b * directions_.second.real())),
                            int(std::lround(b))};
      if (!spot_at_.contains(index)) take(index, found.origin + found.step * offset(index));
    }
  }

  LatticeFit fit() const {
    Complex mean_place = 0.0, mean_offset = 0.0;
    for (const auto& [index, spot] : spot_at_) {
      mean_place += complex_of(spots_[std::size_t(spot)].at_px) / double(spot_at_.size());
      mean_offset += offset(index) / double(spot_at_.size());
    }
    Complex product = 0.0;
    double squares = 0.0;
    for (const auto& [index, spot] : spot_at_) {
      const Complex off = offset(index) - mean_offset;
      product += std::conj(off) * (complex_of(spots_[std::size_t(spot)].at_px) - mean_place);
      squares += std::norm(off);
    }
    LatticeFit fit{mean_place, squares > 0.0 ? product / squares : step_};
    fit.origin -= fit.step * mean_offset;
    double sum = 0.0;
    for (const auto& [index, spot] : spot_at_) {
      const Vec2 off = spots_[std::size_t(spot)].at_px - fit.at(index, directions_.second);
      sum += off.x * off.x + off.y * off.y;
    }
    fit.residual_px = std::sqrt(sum / (2.0 * double(spot_at_.size())));
    fit.step_error_px = squares > 0.0 ? fit.residual_px / std::sqrt(squares) : 0.0;
    return fit;
  }

  const std::map<GridIndex, int>& spot_at() const { return spot_at_; }

  /// The lit nodes among the eight around a node.
  std::vector<GridIndex> lit_around(const GridIndex& index) const {
    std::vector<GridIndex> around;
    for (int k = 0; k < 9; ++k) {
      const GridIndex near{index.first + k % 3 - 1, index.second + k / 3 - 1};
      if (near != index && spot_at_.contains(near)) around.push_back(near);
    }
    return around;
  }

  /// How far a lit node's spot is from the fitted lattice.
  Vec2 displacement(const GridIndex& index, const LatticeFit& fit) const {
    const Vec2 spot_px = spots_[std::size_t(spot_at_.at(index))].at_px;
    return spot_px - fit.at(index, directions_.second);
  }

 private:
  Complex offset(const GridIndex& index) const {
    return double(index.first) + double(index.second) * directions_.second;
  }
  /// The spot nearest the middle of all spots.
  int middle_spot() const {
    Vec2 mean;
    for (const Spot& spot : spots_) mean = mean + (1.0 / double(spots_.size())) * spot.at_px;
    const auto closest = std::min_element(
        spots_.begin(), spots_.end(),
        [&](const Spot& a, const Spot& b) { return norm(a.at_px - mean) < norm(b.at_px - mean); });
    return int(closest - spots_.begin());
  }
  bool take(const GridIndex& index, Complex expected) {
    const Vec2 at{expected.real(), expected.imag()};
    const int spot = nearest_.to(at);
    if (spot < 0 || taken_[std::size_t(spot)]) return false;
    if (norm(spots_[std::size_t(spot)].at_px - at) > kCapture * std::abs(step_)) return false;
    taken_[std::size_t(spot)] = true;
    spot_at_[index] = spot;
    return true;
  }

  const std::vector<Spot>& spots_;
  const Directions& directions_;
  Nearest nearest_;
  Complex step_;
  std::map<GridIndex, int> spot_at_;
  std::vector<bool> taken_;
};

/// All nodes of the smallest box of indices around the lit ones, with one more on each side.
std::vector<LensletNode> nodes_of(const Indexing& indexing, const LatticeFit& fit, Complex second) {
  GridIndex least{0, 0}, most{0, 0};
  for (const auto& [index, spot] : indexing.spot_at()) {
    least = {std::min(least.first, index.first), std::min(least.second, index.second)};
    most = {std::max(most.first, index.first), std::max(most.second, index.second)};
  }
  std::vector<LensletNode> nodes;
  for (int b = least.second - 1; b <= most.second + 1; ++b) {
    for (int a = least.first - 1; a <= most.first + 1; ++a) {
      const bool lit = indexing.spot_at().contains({a, b});
      nodes.push_back({a, b, fit.at({a, b}, second), 0.0, lit});
    }
  }
  return nodes;
}

Result<void> check_pitch(double measured_px, const LensletSearch& search) {
  if (std::abs(measured_px / search.pitch_px - 1.0) <= kMaxPitchError) return {};
  return fail(Errc::refused, "array.pitch_um",
              "the spots are " + with_decimals(measured_px, 2) + " camera pixels apart, but " +
                  with_decimals(search.pitch_px, 2) +
                  " are expected: correct array.pitch_um, optics.camera_pitch_um or "
                  "optics.magnification");
}

/// Nodes outside of the light: dark ones that a path over dark ones connects to the border, and
/// those beside them that count in part.
std::vector<LensletNode> outside_of(const LensletMap& map) {
  std::map<GridIndex, const LensletNode*> partial;
  GridIndex least{std::numeric_limits<int>::max(), 0};
  for (const LensletNode& node : map.nodes) {
    least = std::min(least, GridIndex{node.a, node.b});
    if (!node.lit || node.share < 1.0) partial[{node.a, node.b}] = &node;
  }
  std::deque<GridIndex> open{least};  // a corner of the box, which is dark
  std::vector<LensletNode> outside;
  while (!open.empty()) {
    const GridIndex at = open.front();
    open.pop_front();
    const auto found = partial.find(at);
    if (found == partial.end()) continue;
    outside.push_back(*found->second);
    partial.erase(found);
    if (outside.back().lit) continue;
    for (const GridIndex& next : directions_of(Grid::square).neighbours) {
      open.emplace_back(at.first + next.first, at.second + next.second);
    }
  }
  return outside;
}

/// Light of the spot at a lenslet's place: sum over a disc, above the mean of the rim of its cell.
/// Stray light is rarely even.
double light_at(const Image<std::uint16_t>& image, Vec2 at, double pitch_px) {
  const double disc_px = 0.38 * pitch_px, rim_px = 0.5 * pitch_px;
  double sum = 0.0, rim = 0.0;
  int pixels = 0, rim_pixels = 0;
  const int left = std::max(0, int(at.x - rim_px)), top = std::max(0, int(at.y - rim_px));
  for (int y = top; y < std::min(image.height, int(at.y + rim_px) + 2); ++y) {
    for (int x = left; x < std::min(image.width, int(at.x + rim_px) + 2); ++x) {
      const double away = norm(Vec2{double(x), double(y)} - at);
      if (away > rim_px) continue;
      (away <= disc_px ? sum : rim) += image.at(x, y);
      ++(away <= disc_px ? pixels : rim_pixels);
    }
  }
  return rim_pixels == 0 ? 0.0 : sum - rim / rim_pixels * pixels;
}

/// Measures how much each node counts to the pupil, whether or not its spot was found. A dark one
/// is looked for where the lit ones around it are displaced to.
void measure_share(LensletMap& map, const Image<std::uint16_t>& image, const Indexing& indexing,
                   const LatticeFit& fit) {
  std::map<GridIndex, double> light;
  std::vector<double> lights;
  for (const LensletNode& node : map.nodes) {
    if (!node.lit) continue;
    const GridIndex index{node.a, node.b};
    lights.push_back(light_at(image, node.at_px + indexing.displacement(index, fit), map.pitch_px));
    light[index] = lights.back();
  }
  const double lit = kLitLevel * std::max(upper_quantile(std::move(lights), 0.25), 1e-9);
  for (LensletNode& node : map.nodes) {
    const std::vector<GridIndex> around = indexing.lit_around({node.a, node.b});
    if (around.empty()) continue;
    Vec2 off;
    std::vector<double> others;
    for (const GridIndex& near : around) {
      off = off + (1.0 / double(around.size())) * indexing.displacement(near, fit);
      others.push_back(light.at(near));
    }
    const double here =
        node.lit ? light.at({node.a, node.b}) : light_at(image, node.at_px + off, map.pitch_px);
    const double whole = std::max(kWhole * upper_quantile(std::move(others), kAround), lit);
    node.share = std::clamp((here / whole - kNone) / (1.0 - kNone), 0.0, 1.0);
  }
}

/// Mean place of the lenslets, by their shares.
Vec2 centre_of(const LensletMap& map) {
  Vec2 sum;
  double share = 0.0;
  for (const LensletNode& node : map.nodes) {
    sum = sum + node.share * node.at_px;
    share += node.share;
  }
  return share > 0.0 ? (1.0 / share) * sum : Vec2{};
}

}  // namespace

int LensletMap::lit() const {
  return int(std::count_if(nodes.begin(), nodes.end(), [](const auto& node) { return node.lit; }));
}

Result<LensletMap> find_lenslets(const Image<float>& mean_dn, const LensletSearch& search) {
  const Image<std::uint16_t> image = in_16_bits(mean_dn);
  std::vector<Spot> spots = spots_in(image, search.spots);
  drop_dark(spots);
  if (spots.size() < kMinSubapertures) {
    return fail(Errc::refused, "camera",
                std::to_string(spots.size()) + " lenslets are lit, but at least " +
                    std::to_string(kMinSubapertures) +
                    " are required: check that light reaches the array and that the camera is in "
                    "its focal plane, and raise the exposure");
  }
  if (spots.size() > std::size_t(kMaxSubapertures)) {
    return fail(Errc::refused, "camera.roi",
                "more than " + std::to_string(kMaxSubapertures) +
                    " lenslets are lit: reduce the camera's region");
  }
  const Directions directions = directions_of(search.grid);
  const FirstDirection first = first_direction(spots, 2.0 * search.pitch_px, directions.symmetry);
  if (auto right = check_pitch(std::abs(first.step), search); !right) return fail(right.error());
  Indexing indexing(spots, directions, first.step);
  indexing.run();
  if (first.order < kMinOrder ||
      double(indexing.spot_at().size()) < kMinIndexed * double(spots.size())) {
    return fail(Errc::refused, "sensor.grid",
                "the spots do not form the lattice that is configured: correct sensor.grid, "
                "sensor.charge or optics.focal_length_mm, or weaken the aberration of the light");
  }
  const LatticeFit fit = indexing.fit();
  LensletMap map;
  map.pitch_px = std::abs(fit.step);
  const double turn = 2.0 * std::numbers::pi / directions.symmetry;
  map.rotation_deg = std::remainder(std::arg(fit.step), turn) * 180.0 / std::numbers::pi;
  map.residual_px = fit.residual_px;
  map.pitch_error_px = fit.step_error_px;
  map.nodes = nodes_of(indexing, fit, directions.second);
  measure_share(map, image, indexing, fit);
  return map;
}

LensletPupil lenslet_pupil(const LensletMap& map, std::optional<double> diameter_px) {
  LensletPupil pupil;
  pupil.centre_px = centre_of(map);
  double radius_px = 0.5 * diameter_px.value_or(std::numeric_limits<double>::infinity());
  if (!diameter_px) {
    for (const LensletNode& node : outside_of(map)) {
      const double inner_px = norm(node.at_px - pupil.centre_px) - 0.5 * map.pitch_px;
      radius_px = std::min(radius_px, inner_px + node.share * map.pitch_px);
    }
  }
  pupil.diameter_px = 2.0 * radius_px;
  const double reach_px = radius_px - (0.5 - kAtRim) * map.pitch_px;
  for (const LensletNode& node : map.nodes) {
    if (!node.lit || norm(node.at_px - pupil.centre_px) > reach_px) continue;
    pupil.centres_px.push_back(node.at_px - pupil.centre_px);
  }
  std::sort(pupil.centres_px.begin(), pupil.centres_px.end(),
            [](Vec2 a, Vec2 b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
  return pupil;
}

}  // namespace ovws
