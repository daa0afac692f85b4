/// Acquisition from one far-field image of the real hologram, without history.
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/optics/sensor_field.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/wavefront/slope_model.hpp"
#include "tests/support/alloc_guard.hpp"
#include "tests/unit/tracking/sensor_image.hpp"

namespace ovws {
namespace {

using test::expose8;
using test::SensorBench;

TEST(SpotKinds, AreMadeUnlessAllSpotsAreLikeTheModel) {
  const TrackingConfig lg{TrackerKind::lg, 0.3};
  const SpotModel vortex{1, 12.0};
  const auto kinds_of = [&](const std::vector<int>& charges) {
    return SpotKinds::make(lg, vortex, charges).value();
  };
  EXPECT_EQ(kinds_of({}), nullptr);
  EXPECT_EQ(kinds_of({1, -1, 1}), nullptr);
  EXPECT_EQ(kinds_of({1, 0, -1})->count(), 2);
  ASSERT_NE(kinds_of({0, 0, 0}), nullptr);
  EXPECT_EQ(kinds_of({0, 0, 0})->model(0).charge, 0);
  EXPECT_EQ(kinds_of({2, -2, 2})->model(0).charge, 2);
}

struct AcquisitionCase {
  int charge;
  TrackerKind tracker;
};

class Acquire : public testing::TestWithParam<AcquisitionCase> {
 protected:
  Acquire()
      : bench_(test::sensor_bench(GetParam().charge)),
        tracking_{GetParam().tracker, 0.4},
        model_{GetParam().charge, bench_.lambda_d},
        tracker_(make_tracker(tracking_, model_).value()),
        scratch_(tracker_->make_scratch()),
        acquisition_(model_, bench_.model_px, 512, 512) {}

  int acquire(const Image<std::uint8_t>& image) {
    return acquisition_.acquire(view_of(image), *tracker_, scratch_, fixes_);
  }

  /// Position of spot i under these modes by the slope model, accurate to a fraction of lambda/d.
  Vec2 truth(int i, const std::vector<Mode>& modes) const {
    Vec2 at = bench_.model_px[i];
    for (const Mode& mode : modes) {
      const std::vector<int> j{mode.j};
      const auto slopes =
          slope_matrix(bench_.lattice, bench_.sensor, j, tilt_radius(GetParam().charge, tracking_),
                       bench_.px_per_cycle);
      at = at + mode.waves * Vec2{slopes(2 * i, 0), slopes(2 * i + 1, 0)};
    }
    return at;
  }

  void expect_all(const std::vector<Mode>& modes, const std::vector<int>& dark = {}) {
    const int there = bench_.subapertures() - int(dark.size());
    EXPECT_EQ(acquire(expose8(bench_.light(modes, dark), 200.0, 1.0, 2.0)), there);
    for (int i = 0; i < bench_.subapertures(); ++i) {
      if (std::find(dark.begin(), dark.end(), i) != dark.end()) {
        EXPECT_FALSE(fixes_[i].found()) << "subaperture " << i << " is dark";
        continue;
      }
      const Vec2 at = truth(i, modes);
      EXPECT_NEAR(fixes_[i].x, at.x, 0.15 * bench_.lambda_d) << i;
      EXPECT_NEAR(fixes_[i].y, at.y, 0.15 * bench_.lambda_d) << i;
    }
  }

  SensorBench& bench_;
  TrackingConfig tracking_;
  SpotModel model_;
  std::unique_ptr<const SpotTracker> tracker_;
  TrackScratch scratch_;
  Acquisition acquisition_;
  std::vector<SpotFix> fixes_ = std::vector<SpotFix>(19);
};

TEST_P(Acquire, FindsAllSpotsOfAFlatWavefront) {
  expect_all({});
}

TEST_P(Acquire, FindsAllUnderStrongAstigmatismAndFocus) {
  for (const int j : {3, 4, 5}) {
    for (const double waves : {-0.8, 0.8}) expect_all({{j, waves}});
  }
}

TEST_P(Acquire, FindsAllUnderATiltOfAPitch) {
  // 57.8 px between neighbours along x, 83.5 px between rows.
  const double px_per_wave = 4.0 / bench_.sensor.pupil_diameter_px * bench_.px_per_cycle;
  expect_all({{2, 57.8 / px_per_wave}});
  expect_all({{1, -60.0 / px_per_wave}});
  expect_all({{2, -40.0 / px_per_wave}, {1, 30.0 / px_per_wave}, {3, 0.5}});
}

TEST_P(Acquire, FindsAllUnderAMixtureOfModes) {
  expect_all({{3, 0.2}, {4, -0.3}, {5, 0.15}, {7, 0.1}, {8, -0.1}, {12, 0.05}});
}

TEST_P(Acquire, ReportsMissingSpotsAsLost) {
  expect_all({}, {9});
  expect_all({}, {0, 1, 2});
  expect_all({{4, 0.4}}, {4, 11, 18});
}

TEST_P(Acquire, FindsNothingInBlackAndSaturatedImages) {
  for (const int level : {0, 7, 255}) {
    EXPECT_EQ(acquire(Image<std::uint8_t>(512, 512, std::uint8_t(level))), 0);
    for (const SpotFix& fix : fixes_) EXPECT_FALSE(fix.found());
  }
}

TEST_P(Acquire, FindsNothingInNoise) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Image<float> nothing(512, 512);
    EXPECT_EQ(acquire(expose8(nothing, 1.0, 0.5 + seed, 5.0 * (seed % 3), seed)), 0);
    for (const SpotFix& fix : fixes_) EXPECT_FALSE(fix.found());
  }
}

TEST_P(Acquire, FindsAllInALowExposure) {
  EXPECT_EQ(acquire(expose8(bench_.light({}), 25.0, 2.0, 4.0)), 19);
}

TEST_P(Acquire, FindsNothingInAnImageOfAnotherSize) {
  EXPECT_EQ(acquire(Image<std::uint8_t>(512, 500, 3)), 0);
}

/// One for another hologram, which shares the memory for the image.
TEST_P(Acquire, FindsTheSameWithMemoryThatIsShared) {
  const std::vector<Mode> focus{{4, 0.3}};
  const auto flat = expose8(bench_.light({}), 200.0, 1.0, 2.0);
  const auto focused = expose8(bench_.light(focus), 200.0, 1.0, 2.0);
  std::vector<Vec2> places = bench_.model_px;
  for (int i = 0; i < int(places.size()); ++i) places[std::size_t(i)] = truth(i, focus);
  Acquisition next(model_, places, 512, 512, &acquisition_);
  std::vector<SpotFix> found(fixes_.size());
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(acquire(flat), bench_.subapertures());
    EXPECT_EQ(next.acquire(view_of(focused), *tracker_, scratch_, found), bench_.subapertures());
  }
  Acquisition small(model_, bench_.model_px, 256, 256, &next);
  EXPECT_EQ(small.acquire(view_of(flat), *tracker_, scratch_, found), 0);
  EXPECT_EQ(acquire(flat), bench_.subapertures());
}

TEST_P(Acquire, DoesNotAllocate) {
  const auto image = expose8(bench_.light({}, {4}), 200.0);
  const test::AllocGuard guard;
  const int found = acquire(image);
  const auto allocations = guard.allocations();
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(found, 18);
}

std::string acquisition_name(const testing::TestParamInfo<AcquisitionCase>& info) {
  const int charge = info.param.charge;
  return std::string(tracker_name(info.param.tracker)) + (charge < 0 ? "_minus_" : "_") +
         std::to_string(std::abs(charge));
}
INSTANTIATE_TEST_SUITE_P(Methods, Acquire,
                         testing::Values(AcquisitionCase{1, TrackerKind::lg},
                                         AcquisitionCase{-1, TrackerKind::lg},
                                         AcquisitionCase{2, TrackerKind::lg},
                                         AcquisitionCase{0, TrackerKind::lg},
                                         AcquisitionCase{0, TrackerKind::thresholded}),
                         acquisition_name);

/// A fixed array in light that is wider than the pupil: every lenslet gives a spot, and only those
/// in the pupil are measured. 150 um lenslets, f = 5.2 mm, pixels of 5.3 um.
struct WideArray {
  int columns, rows, pupil;  ///< lenslets that are lit, and that fit into the pupil's diameter
  int charge;
  double depth = 1.0;  ///< of the spiral plates
  Vec2 size_px{};      ///< of the image; zero: that of the array
};

class WideLight {
 public:
  explicit WideLight(const WideArray& array)
      : columns_(array.size_px.x > 0.0 ? int(array.size_px.x) : int(kPitch * (array.columns + 1))),
        rows_(array.size_px.y > 0.0 ? int(array.size_px.y) : int(kPitch * (array.rows + 1))) {
    sensor_.charge = array.charge;
    sensor_.grooves = {0.0, 0.0};
    sensor_.pupil_diameter_px = array.pupil * kPitch;
    sensor_.lenslets = {LensletShape::square, kPitch, 0.0, {16, array.depth, {}}, kPxPerCycle, {}};
    for (int k = 0; k < array.columns * array.rows; ++k) {
      lit_.push_back({kPitch * (k % array.columns - array.columns / 2),
                      kPitch * (k / array.columns - array.rows / 2)});
    }
    optics_.registered = PxPerCycle(kPxPerCycle);
    optics_.centre_px = Vec2{0.5 * columns_ + 0.3, 0.5 * rows_ - 0.2};
    for (const Vec2 at : lit_) {
      if (norm(at) > 0.5 * (array.pupil - 1) * kPitch + 0.1) continue;
      in_use_px_.push_back(at + *optics_.centre_px);
    }
    sensor_.lenslets.centres_px = lit_;
  }

  /// The image of the lit lenslets but the `dark` ones (numbers in in_use_px).
  Image<std::uint8_t> image(const std::vector<Mode>& modes, const std::vector<int>& dark,
                            unsigned seed) {
    const SlmGeometry no_slm{16, 16, 5.3};
    sensor_.lenslets.centres_px = lit_;
    for (const int i : dark) {
      std::erase_if(sensor_.lenslets.centres_px, [&](Vec2 at) {
        return norm(at + *optics_.centre_px - in_use_px_[std::size_t(i)]) < 1.0;
      });
    }
    auto field = SensorField::make(sensor_, no_slm, optics_, columns_, rows_).value();
    field.propagate(modes, {});
    Image<float> light(columns_, rows_);
    std::transform(field.far().pixels.begin(), field.far().pixels.end(), light.pixels.begin(),
                   [](std::complex<float> one) { return std::norm(one); });
    const float peak = *std::max_element(light.pixels.begin(), light.pixels.end());
    for (float& pixel : light.pixels) pixel /= peak;
    return expose8(light, 200.0, 1.0, 4.0, seed);
  }

  /// Largest distance of the spots found from where the modes move them, and how many are found.
  struct Found {
    int spots = 0;
    double farthest_px = 0.0;
  };
  Found search(const Image<std::uint8_t>& image, const std::vector<Mode>& modes) const {
    const SpotModel spots{sensor_.charge, lambda_d_px(optics_, {16, 16, 5.3}, sensor_)};
    const TrackingConfig lg{TrackerKind::lg, 0.3};
    const auto tracker = make_tracker(lg, spots).value();
    TrackScratch scratch = tracker->make_scratch();
    std::vector<SpotFix> fixes(in_use_px_.size());
    Found found;
    found.spots = Acquisition(spots, in_use_px_, columns_, rows_)
                      .acquire(view_of(image), *tracker, scratch, fixes);
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      if (!fixes[i].found()) continue;
      const Vec2 at = in_use_px_[i] - *optics_.centre_px;
      const double radius_px = 0.5 * sensor_.pupil_diameter_px;
      const Vec2 moved =
          (kPxPerCycle / radius_px) * wavefront_gradient(modes, (1.0 / radius_px) * at);
      const Vec2 off = Vec2{double(fixes[i].x), double(fixes[i].y)} - in_use_px_[i] - moved;
      found.farthest_px = std::max(found.farthest_px, norm(off));
    }
    return found;
  }

  int lit() const { return int(lit_.size()); }
  int in_use() const { return int(in_use_px_.size()); }

  static constexpr double kPitch = 150.0 / 5.3, kPxPerCycle = 632e-3 * 5.2e3 / (5.3 * 5.3);

 private:
  int columns_, rows_;
  SensorConfig sensor_;
  OpticsConfig optics_;
  std::vector<Vec2> lit_, in_use_px_;
};

TEST(AcquireInWideLight, FindsTheLensletsOfThePupil) {
  const std::vector<std::vector<Mode>> lights{
      {{1, 0.2}, {2, -0.15}}, {{7, -0.12}, {8, 0.12}}, {{3, 0.1}, {4, -0.15}, {8, 0.05}}};
  unsigned next = 0;
  for (const WideArray& array :
       {WideArray{17, 15, 11, 0}, WideArray{9, 9, 7, 1, 0.95}, WideArray{11, 11, 7, 0},
        WideArray{13, 11, 7, 1}, WideArray{9, 9, 7, 0, 1.0, {384, 384}}, WideArray{31, 25, 13, 0},
        WideArray{11, 11, 7, 1}}) {
    WideLight light(array);
    const std::vector<Mode>& modes = lights[next++ % lights.size()];
    const auto found = light.search(light.image(modes, {}, next), modes);
    std::printf("  %d lit, %d in use, charge %d: %d found, farthest %.2f px\n", light.lit(),
                light.in_use(), array.charge, found.spots, found.farthest_px);
    EXPECT_GE(found.spots, light.in_use() - (array.charge == 0 ? 0 : 3));  // coma splits vortices
    EXPECT_LT(found.farthest_px, 0.05 * WideLight::kPitch);
  }
}

TEST(AcquireInWideLight, DarkLensletsAreLostAndShiftNothing) {
  WideLight light({11, 11, 7, 0});
  const std::vector<int> dark{0, 1, 14};
  const auto found = light.search(light.image({{4, 0.1}}, dark, 5), {{4, 0.1}});
  EXPECT_EQ(found.spots, light.in_use() - int(dark.size()));
  EXPECT_LT(found.farthest_px, 0.05 * WideLight::kPitch);
}

}  // namespace
}  // namespace ovws
