#include "core/wavefront/shaped_acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/tracking/patch.hpp"

namespace ovws {
namespace {

constexpr double kBinsPerLambdaD = 6.0;
constexpr double kSpotHalf = 3.0;       // lambda/d: extent of a split spot
constexpr float kMinConfidence = 0.6F;  // quality: below, the fix may be one half of a split spot
constexpr double kAgree = 0.25;         // lambda/d

constexpr double kMaxStartShift = 0.6;  // of the pitch: largest shift of a start from few spots
constexpr double kMinStartShare = 0.3;  // of the lattice: enough spots for such a start
constexpr Vec2 kNowhere{std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::quiet_NaN()};

std::vector<Vec2> starts_of(std::span<const SpotFix> fixes) {
  std::vector<Vec2> starts;
  for (const SpotFix& fix : fixes) starts.push_back({double(fix.x), double(fix.y)});
  return starts;
}

int max_seen(std::size_t subapertures) {
  return int(4 * subapertures) + 12;
}

ShapeModel model_of(const Lattice& lattice, const SensorConfig& sensor, const SpotModel& spots,
                    const PxPerCycle& px_per_cycle, const std::vector<int>& modes_j,
                    const Eigen::MatrixXd& slopes, const std::vector<Vec2>& reference_px) {
  const ColourPlane& lit = spots.lit.plane;
  const int bin = std::max(1, int(spots.on_plane().lambda_d_px / kBinsPerLambdaD));
  const int bin_px = bin * lit.step;
  const int half = int(std::ceil(kSpotHalf * spots.lambda_d_px / bin_px));
  return {SpotOptics(lattice, sensor, modes_j, px_per_cycle / bin_px, half),
          lit,
          bin,
          spots.lambda_d_px,
          slopes,
          reference_px};
}

}  // namespace

ShapedAcquisition::ShapedAcquisition(const Lattice& lattice, const SensorConfig& sensor,
                                     const SpotModel& spots, const PxPerCycle& px_per_cycle,
                                     const std::vector<int>& modes_j, const Eigen::MatrixXd& slopes,
                                     const std::vector<Vec2>& reference_px, int image_width,
                                     int image_height)
    : plain_(spots, reference_px, image_width, image_height),
      assignment_(reference_px, max_seen(reference_px.size())),
      lambda_d_px_(spots.lambda_d_px),
      make_model_([=] {
        return model_of(lattice, sensor, spots, px_per_cycle, modes_j, slopes, reference_px);
      }) {}

int ShapedAcquisition::acquire(const ImageView& image, const SpotTracker& tracker,
                               TrackScratch& scratch, std::span<SpotFix> out, bool trust_tracker,
                               const std::vector<Vec2>& followed) {
  shapes_.clear();
  split_.assign(out.size(), false);
  const int found = plain_.acquire(image, tracker, scratch, out);
  const bool all_confident = std::all_of(out.begin(), out.end(), [](const SpotFix& fix) {
    return fix.found() && fix.quality > kMinConfidence;
  });
  if ((all_confident && trust_tracker) || plain_.seen().empty()) return found;
  if (!model_) model_.emplace(make_model_());
  const BinnedImage bins = binned(image, model_->lit, model_->bin);
  int most_explained = (3 * int(out.size()) - 1) / 4;
  // Several starts: the whole lattice may be assigned one pitch off, with one row unexplained.
  for (const auto& starts :
       {starts_of_seen({}),
        starts_of_seen({kMinStartShare, kMaxStartShift * assignment_.pitch_px()}), starts_of(out),
        followed}) {
    if (starts.size() != out.size()) continue;
    ShapeFit fit(*model_, bins);
    const int explained = fit.run(starts);
    if (explained <= most_explained) continue;
    most_explained = explained;
    shapes_ = fit.spots();
    waves_ = fit.waves();
    if (most_explained == int(out.size())) break;
  }
  for (std::size_t i = 0; i < shapes_.size(); ++i) split_[i] = apply(image, shapes_[i], out[i]);
  return int(std::count_if(out.begin(), out.end(), [](const SpotFix& s) { return s.found(); }));
}

std::vector<Vec2> ShapedAcquisition::starts_of_seen(const SpotAssignment::Rules& rules) {
  std::vector<Vec2> starts(split_.size(), kNowhere);
  const std::vector<Vec2> seen = plain_.seen();
  const std::span<const int> owned = assignment_.match(seen, rules);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    if (owned[i] != SpotAssignment::kNone) starts[i] = seen[std::size_t(owned[i])];
  }
  return starts;
}

/// Applies the fit to one fix. True if the fit found the spot, but the tracker did not there.
bool ShapedAcquisition::apply(const ImageView& image, const ShapedSpot& shaped,
                              SpotFix& fix) const {
  const Vec2 at{double(fix.x), double(fix.y)};
  if (fix.found() && norm(at - shaped.at_px) < kAgree * lambda_d_px_) return false;
  fix = {};
  fix.peak = brightest_pixel(image, shaped.at_px, int(lambda_d_px_));
  if (!shaped.found) return false;
  fix.x = float(shaped.at_px.x);
  fix.y = float(shaped.at_px.y);
  fix.quality = float(1.0 - shaped.unexplained);
  fix.level = float(shaped.amplitude);
  return true;
}

}  // namespace ovws
