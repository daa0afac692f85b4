/// End to end: modes of the hologram, propagated to the far field and rounded to 8 bit, are
/// measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/tracking/acquisition.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "core/wavefront/slope_model.hpp"
#include "tests/unit/tracking/sensor_image.hpp"

namespace ovws {
namespace {

struct Method {
  int charge;
  TrackingConfig tracking;
};

/// The bench's intensity, cached: several methods use the same images.
const Image<float>& light_of(int charge, const std::vector<Mode>& shown) {
  static std::map<std::tuple<int, int, double>, Image<float>> kept;
  const Mode mode = shown.empty() ? Mode{} : shown.front();
  const auto key = std::tuple{charge, mode.j, mode.waves};
  const auto known = kept.find(key);
  if (known != kept.end()) return known->second;
  return kept[key] = test::sensor_bench(charge).light(shown);
}

/// The paper's modes j = 1 .. 18, measured from images without history.
class Chain {
 public:
  explicit Chain(const Method& method)
      : bench_(test::sensor_bench(method.charge)),
        modes_(18),
        tracker_(make_tracker(method.tracking, {method.charge, bench_.lambda_d}).value()),
        scratch_(tracker_->make_scratch()),
        acquisition_({method.charge, bench_.lambda_d}, bench_.model_px, 512, 512) {
    std::iota(modes_.begin(), modes_.end(), 1);
    slopes_ = slope_matrix(bench_.lattice, bench_.sensor, modes_,
                           tilt_radius(method.charge, method.tracking), bench_.px_per_cycle);
    for (const SpotFix& fix : spots({})) reference_.push_back({double(fix.x), double(fix.y)});
  }

  std::vector<float> measure(const std::vector<Mode>& shown) {
    const Reconstructor reconstructor(slopes_, modes_, reference_);
    auto scratch = reconstructor.make_scratch();
    std::vector<float> coefficients(modes_.size());
    const Reconstruction r = reconstructor.solve(spots(shown), scratch, coefficients);
    EXPECT_TRUE(r.determined);
    return coefficients;
  }

  int most_lost() const { return most_lost_; }

 private:
  /// Acquired without history, then tracked once more from there, as in a second frame.
  std::vector<SpotFix> spots(const std::vector<Mode>& shown) {
    const auto image =
        test::expose8(light_of(bench_.sensor.charge, shown), 200.0, 1.0, 2.0, seed_++);
    std::vector<SpotFix> fixes(std::size_t(bench_.subapertures()));
    const int found = acquisition_.acquire(view_of(image), *tracker_, scratch_, fixes);
    most_lost_ = std::max(most_lost_, int(fixes.size()) - found);
    for (SpotFix& fix : fixes) {
      if (!fix.found()) continue;
      fix = tracker_->track(view_of(image), {double(fix.x), double(fix.y)}, scratch_);
      EXPECT_TRUE(fix.found());
    }
    return fixes;
  }

  test::SensorBench& bench_;
  std::vector<int> modes_;
  Eigen::MatrixXd slopes_;
  std::vector<Vec2> reference_;
  std::unique_ptr<const SpotTracker> tracker_;
  TrackScratch scratch_;
  Acquisition acquisition_;
  unsigned seed_ = 1;
  int most_lost_ = 0;
};

struct Worst {
  double own = 0.0;    ///< |error| / (5 % + 0.005 wave)
  double other = 0.0;  ///< waves
  std::string own_at, other_at;
  int lost = 0;  ///< most spots lost in one image
};

Worst worst_of(const Method& method) {
  Chain chain(method);
  std::vector<Mode> cases;
  for (int j = 3; j <= 14; ++j) {
    cases.push_back({j, 0.2});
    cases.push_back({j, -0.2});
  }
  cases.push_back({osa_index({2, -2}), 0.5});
  Worst worst;
  for (const Mode& shown : cases) {
    const auto found = chain.measure({shown});
    const std::string name = "j=" + std::to_string(shown.j) + (shown.waves > 0 ? "+" : "-");
    for (int j = 1; j <= 18; ++j) {
      const double value = double(found[std::size_t(j) - 1]);
      const double own = std::abs(value - shown.waves) / (0.05 * std::abs(shown.waves) + 0.005);
      if (j == shown.j && !(own <= worst.own)) {
        worst.own = own;
        worst.own_at = name;
      }
      if (j != shown.j && !(std::abs(value) <= worst.other)) {
        worst.other = std::abs(value);
        worst.other_at = name + " in j=" + std::to_string(j);
      }
    }
  }
  worst.lost = chain.most_lost();
  std::printf("  %s, charge %d, kernel %.1f: own error %.2f of 5 %% + 0.005 wave (%s), ",
              std::string(tracker_name(method.tracking.tracker)).c_str(), method.charge,
              method.tracking.kernel_radius, worst.own, worst.own_at.c_str());
  std::printf("others %.4f wave (%s), lost spots %d\n", worst.other, worst.other_at.c_str(),
              worst.lost);
  return worst;
}

class EndToEnd : public testing::TestWithParam<Method> {};

TEST_P(EndToEnd, EachModeIsRightToFivePercentAndLeaksNowhere) {
  const Worst worst = worst_of(GetParam());
  EXPECT_LT(worst.own, 1.0) << worst.own_at;
  EXPECT_LT(worst.other, 0.02) << worst.other_at;
  // 0.2 wave of spherical aberration leaves no sharp core in one subaperture at the pupil's rim.
  EXPECT_LE(worst.lost, GetParam().charge == 0 ? 0 : 1);
}

std::string method_name(const testing::TestParamInfo<Method>& info) {
  return std::string(tracker_name(info.param.tracking.tracker)) + "_" +
         std::to_string(std::abs(info.param.charge)) + (info.param.charge < 0 ? "_minus" : "") +
         (info.param.tracking.kernel_radius < 0.35 ? "_narrow" : "");
}
INSTANTIATE_TEST_SUITE_P(
    Methods, EndToEnd,
    testing::Values(Method{1, {TrackerKind::lg, 0.4}}, Method{1, {TrackerKind::lg, 0.3}},
                    Method{-1, {TrackerKind::lg, 0.4}}, Method{0, {TrackerKind::thresholded, 0.4}},
                    Method{0, {TrackerKind::weighted, 0.4}}, Method{0, {TrackerKind::lg, 0.4}}),
    method_name);

/// A plain centroid includes the intensity of neighbouring spots, and charge 2 loses cores: both
/// leak more than 0.02 wave at worst. The limits leave a third above what they reach (0.021 wave, 2
/// spots).
TEST(EndToEndCentroidAndChargeTwo, AreRightToFivePercentAndLeakLessThanThreeHundredthsOfAWave) {
  for (const Method& method :
       {Method{0, {TrackerKind::centroid, 0.4}}, Method{2, {TrackerKind::lg, 0.4}}}) {
    const Worst worst = worst_of(method);
    EXPECT_LT(worst.own, 0.6) << worst.own_at;
    EXPECT_LT(worst.other, 0.028) << worst.other_at;
    EXPECT_LE(worst.lost, method.charge == 0 ? 0 : 3);
  }
}

}  // namespace
}  // namespace ovws
