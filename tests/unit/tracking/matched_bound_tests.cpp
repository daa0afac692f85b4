/// The matched filter against the Cramer-Rao bound.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/tracking/localisation_bound.hpp"
#include "core/tracking/matched.hpp"
#include "core/tracking/reference_shape.hpp"
#include "tests/unit/tracking/noisy_spot.hpp"

namespace ovws {
namespace {

constexpr int kPositions = 12, kRealisations = 36;
constexpr double kLambdaD = 12.55;
constexpr int kHalf = 32;  // half-width of the bound's window: the whole image
const std::vector<double> kSnr{2.0, 3.0, 4.5, 6.0, 9.0, 12.0, 16.0, 22.0};

struct Errors {
  double sum = 0.0;
  int found = 0, tried = 0;

  void add(const SpotFix& fix, Vec2 truth) {
    ++tried;
    if (!fix.found()) return;
    ++found;
    sum += std::pow(double(fix.x) - truth.x, 2) + std::pow(double(fix.y) - truth.y, 2);
  }
  double rms() const { return std::sqrt(sum / (2.0 * found)); }
};

SpotExposure exposure_of(double snr) {
  return {test::kNoisyPeak, 0.0, test::read_noise_of(snr)};
}

class Bound : public testing::TestWithParam<int> {
 protected:
  Bound()
      : spots_{GetParam(), kLambdaD},
        shape_(spots_, 8.0),
        matched_(spots_),
        lg_(make_tracker({TrackerKind::lg, 0.3}, spots_).value()) {}

  double bound_px(double snr) const {
    return localisation_bound(shape_, {36.2, 35.9}, kHalf, exposure_of(snr)).px;
  }

  /// Calls use(image, truth, start) for every realisation.
  template <class Use>
  void each(double snr, Use use) const {
    std::mt19937 random{unsigned(10 * snr)};
    std::uniform_real_distribution<double> place(34.0, 38.0), off(-2.0, 2.0);
    for (int p = 0; p < kPositions; ++p) {
      const Vec2 truth{place(random), place(random)};
      const Image<float> mean = test::mean_electrons(shape_, truth);
      for (int k = 0; k < kRealisations; ++k) {
        const auto image = test::expose12(mean, test::read_noise_of(snr), random());
        use(image, truth, truth + Vec2{off(random), off(random)});
      }
    }
  }

  SpotModel spots_;
  ModelShape shape_;
  MatchedTracker matched_;
  std::unique_ptr<const SpotTracker> lg_;
};

TEST_P(Bound, IsReachedToAQuarterAtEverySignal) {
  auto scratch = matched_.make_scratch();
  auto lg_scratch = lg_->make_scratch();
  for (const double snr : kSnr) {
    Errors matched, lg;
    each(snr, [&](const Image<std::uint16_t>& image, Vec2 truth, Vec2 start) {
      const ImageView view = view_of(image, PixelFormat::mono12);
      matched.add(matched_.track(view, start, scratch), truth);
      lg.add(lg_->track(view, start, lg_scratch), truth);
    });
    const double bound = bound_px(snr);
    std::printf(
        "  charge %d, SNR %4.1f, read noise %5.1f e: bound %.4f px, matched %.3f x (%d of "
        "%d found), lg %.2f x (%d)\n",
        GetParam(), snr, test::read_noise_of(snr), bound, matched.rms() / bound, matched.found,
        matched.tried, lg.rms() / bound, lg.found);
    EXPECT_LE(matched.rms(), 1.25 * bound) << snr;
    EXPECT_GE(matched.found, matched.tried * 99 / 100) << snr;
  }
}

/// Templates from the average of 100 noisy frames.
TEST_P(Bound, IsReachedWithAReferenceOf100NoisyFramesToo) {
  for (const double snr : {2.0, 4.5, 9.0, 22.0}) {
    const Vec2 reference{36.3, 35.6};
    const Image<float> mean = test::mean_electrons(shape_, reference);
    Image<float> average(mean.width, mean.height);
    for (unsigned k = 0; k < 100; ++k) {
      const auto frame = test::expose12(mean, test::read_noise_of(snr), 1000 + k);
      for (std::size_t i = 0; i < frame.pixels.size(); ++i) {
        average.pixels[i] += float(frame.pixels[i]) / 100.0F;
      }
    }
    const std::vector<Vec2> positions{reference};
    const MatchedTracker own(spots_, reference_templates(spots_, average, positions));
    auto scratch = own.make_scratch();
    Errors errors;
    each(snr, [&](const Image<std::uint16_t>& image, Vec2 truth, Vec2 start) {
      errors.add(own.track(view_of(image, PixelFormat::mono12), start, scratch, 0), truth);
    });
    const double bound = bound_px(snr);
    std::printf("  charge %d, SNR %4.1f, templates of the reference: %.3f x bound (%d of %d)\n",
                GetParam(), snr, errors.rms() / bound, errors.found, errors.tried);
    EXPECT_LE(errors.rms(), 1.3 * bound) << snr;
    EXPECT_GE(errors.found, errors.tried * 99 / 100) << snr;
  }
}

std::string charge_name(const testing::TestParamInfo<int>& info) {
  return "charge_" + std::to_string(info.param);
}
INSTANTIATE_TEST_SUITE_P(Charge, Bound, testing::Values(0, 1), charge_name);

}  // namespace
}  // namespace ovws
