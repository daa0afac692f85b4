// Pixel formats: equal values give equal spots in every packing, and a colour camera's lit pixels
// give the positions that a monochrome camera gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/spots/position_fit.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/binned_image.hpp"
#include "core/tracking/cell_centroid.hpp"
#include "core/tracking/patch.hpp"
#include "tests/support/alloc_guard.hpp"
#include "tests/unit/base/packed_image.hpp"
#include "tests/unit/tracking/sensor_image.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::kLambdaD;
using test::SpotImage;

/// An image packed in a pixel format, and a view of it.
struct Packed {
  Packed(const Image<std::uint16_t>& dn, PixelFormat format, int shift = 0)
      : bytes(test::pack(dn, format, 0, shift)),
        view(test::packed_view(bytes, dn.width, dn.height, format, 0, shift)) {}
  std::vector<std::byte> bytes;
  ImageView view;
};

/// Attenuates the pixels under the other colour filters.
Image<std::uint16_t> filtered(Image<std::uint16_t> dn, const LitPixels& lit) {
  for (int y = 0; y < dn.height; ++y) {
    for (int x = 0; x < dn.width; ++x) {
      const auto on = [&](const ColourPlane& l) { return x % 2 == l.x && y % 2 == l.y; };
      if (!on(lit.plane) && !(lit.diagonal && on(lit.other()))) dn.at(x, y) /= 30;
    }
  }
  return dn;
}

Image<std::uint16_t> spot_at(int charge, Vec2 at, int full) {
  SpotImage picture;
  picture.pedestal_dn = 0.02;
  picture.light = Image<float>(picture.width, picture.height, 0.02F);
  picture.add(charge, at, 0.8);
  return picture.mono16(full, full);
}

std::vector<TrackerKind> kinds_for(int charge) {
  if (charge != 0) return {TrackerKind::lg, TrackerKind::lg_contour};
  return {TrackerKind::lg, TrackerKind::centroid, TrackerKind::thresholded, TrackerKind::weighted};
}

void expect_same(const SpotFix& a, const SpotFix& b, const std::string& what) {
  ASSERT_EQ(a.found(), b.found()) << what;
  EXPECT_EQ(a.peak, b.peak) << what;
  if (!a.found()) return;
  EXPECT_EQ(a.x, b.x) << what;
  EXPECT_EQ(a.y, b.y) << what;
  EXPECT_EQ(a.quality, b.quality) << what;
  EXPECT_EQ(a.level, b.level) << what;
  EXPECT_EQ(a.noise, b.noise) << what;
}

struct Repacked {
  PixelFormat plain, packed;
  int shift;
};

class SameNumbers : public testing::TestWithParam<Repacked> {};

// Spots in the middle, and so near each edge that the patch extends beyond it.
TEST_P(SameNumbers, AreTheSameSpotToEveryTracker) {
  const auto [plain, packed, shift] = GetParam();
  const std::vector<Vec2> places{{63.3, 58.8}, {22.4, 60.0}, {104.7, 60.2},
                                 {60.1, 21.6}, {60.4, 97.9}, {8.0, 8.0}};
  for (const int charge : {0, 1}) {
    for (const TrackerKind kind : kinds_for(charge)) {
      const auto tracker = make_tracker({kind, 0.4}, {charge, kLambdaD}).value();
      TrackScratch scratch = tracker->make_scratch();
      for (const Vec2 at : places) {
        const auto dn = spot_at(charge, at, int(full_scale_dn(plain)));
        const Packed a(dn, plain), b(dn, packed, shift);
        for (const Vec2 off : {Vec2{0.0, 0.0}, Vec2{6.0, -7.0}}) {
          const SpotFix expected = tracker->track(a.view, at + off, scratch);
          const test::AllocGuard guard;
          const SpotFix found = tracker->track(b.view, at + off, scratch);
          const bool may_allocate = kind == TrackerKind::lg_contour;
          EXPECT_TRUE(may_allocate || guard.allocations() == 0);
          expect_same(expected, found, std::string(tracker_name(kind)));
        }
      }
    }
  }
}

TEST_P(SameNumbers, AreTheSameToAllThatReadsWholeImages) {
  const auto [plain, packed, shift] = GetParam();
  auto& bench = test::sensor_bench(1);
  const Image<float> light = bench.light({});
  const double full = full_scale_dn(plain);
  Image<std::uint16_t> dn(512, 512);
  for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
    dn.pixels[k] = std::uint16_t(full * (0.01 + 0.8 * double(light.pixels[k])));
  }
  const Packed a(dn, plain), b(dn, packed, shift);
  const SpotModel spots{1, bench.lambda_d};
  const auto tracker = make_tracker({}, spots).value();
  TrackScratch scratch = tracker->make_scratch();
  Acquisition acquisition(spots, bench.model_px, 512, 512);
  std::vector<SpotFix> expected(19), found(19);
  ASSERT_EQ(acquisition.acquire(a.view, *tracker, scratch, expected), 19);
  ASSERT_EQ(acquisition.acquire(b.view, *tracker, scratch, found), 19);
  for (std::size_t i = 0; i < found.size(); ++i) expect_same(expected[i], found[i], "acquired");
  const Vec2 at = bench.model_px[4];
  EXPECT_EQ(cell_centroid(a.view, at, 30), cell_centroid(b.view, at, 30));
  EXPECT_EQ(brightest_pixel(a.view, at, 30), brightest_pixel(b.view, at, 30));
  EXPECT_EQ(binned(a.view, {}, 3).intensity, binned(b.view, {}, 3).intensity);
}

INSTANTIATE_TEST_SUITE_P(
    All, SameNumbers,
    testing::Values(Repacked{PixelFormat::mono10, PixelFormat::mono10p, 0},
                    Repacked{PixelFormat::mono10, PixelFormat::mono10_packed, 0},
                    Repacked{PixelFormat::mono12, PixelFormat::mono12p, 0},
                    Repacked{PixelFormat::mono12, PixelFormat::mono12_packed, 0},
                    Repacked{PixelFormat::mono10, PixelFormat::mono10, 6},
                    Repacked{PixelFormat::mono12, PixelFormat::mono12, 4},
                    Repacked{PixelFormat::mono14, PixelFormat::mono14, 2}),
    [](const auto& given) {
      return std::string(pixel_format_name(given.param.packed)) +
             (given.param.shift > 0 ? "LeftJustified" : "");
    });

constexpr double kRedNm = 632.0, kGreenNm = 532.0, kBlueNm = 450.0;

struct Colour {
  PixelFormat format;
  double wavelength_nm;
};

class ColourCamera : public testing::TestWithParam<Colour> {
 protected:
  LitPixels lit() const { return lit_pixels(GetParam().format, GetParam().wavelength_nm); }
  int full() const { return int(full_scale_dn(GetParam().format)); }
};

// Half-pixel offsets, parity and x/y order: spots between lit pixels, on them, and on unlit ones.
TEST_P(ColourCamera, SeesASpotWhereItIs) {
  const std::vector<Vec2> places{{63.0, 58.0}, {64.0, 59.0}, {63.5, 58.5}, {62.27, 60.81}};
  for (const int charge : {0, 1, 2}) {
    for (const TrackerKind kind : kinds_for(charge)) {
      const SpotModel spots{charge, kLambdaD, lit()};
      const auto tracker = make_tracker({kind, 0.4}, spots).value();
      TrackScratch scratch = tracker->make_scratch();
      if (kind == TrackerKind::centroid) continue;  // biased towards its start by the background
      for (const Vec2 at : places) {
        const auto dn = spot_at(charge, at, full());
        const Packed image(filtered(dn, lit()), GetParam().format);
        const SpotFix fix = tracker->track(image.view, at + Vec2{2.0, -3.0}, scratch);
        ASSERT_TRUE(fix.found()) << tracker_name(kind) << " charge " << charge;
        const bool coarse = full() == 255 || kind == TrackerKind::thresholded;
        const double bound_px = coarse ? 0.02 : 0.01;
        EXPECT_NEAR(fix.x, at.x, bound_px) << tracker_name(kind) << " charge " << charge;
        EXPECT_NEAR(fix.y, at.y, bound_px) << tracker_name(kind) << " charge " << charge;
      }
    }
  }
}

TEST_P(ColourCamera, FindsAllSpotsWithoutHistoryWhereACameraWithoutFiltersDoes) {
  auto& bench = test::sensor_bench(1);
  const Image<float> light = bench.light(std::vector<Mode>{{5, 0.3}, {3, -0.2}});
  Image<std::uint16_t> dn(512, 512);
  for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
    dn.pixels[k] = std::uint16_t(full() * (0.01 + 0.8 * double(light.pixels[k])));
  }
  const auto acquire = [&](const SpotModel& spots, const ImageView& image) {
    const auto tracker = make_tracker({}, spots).value();
    TrackScratch scratch = tracker->make_scratch();
    Acquisition acquisition(spots, bench.model_px, 512, 512);
    std::vector<SpotFix> fixes(19);
    EXPECT_EQ(acquisition.acquire(image, *tracker, scratch, fixes), 19);
    return fixes;
  };
  const Packed plain(dn, PixelFormat::mono12), colour(filtered(dn, lit()), GetParam().format);
  const auto expected = acquire({1, bench.lambda_d}, plain.view);
  const auto found = acquire({1, bench.lambda_d, lit()}, colour.view);
  // Fringes between the tails of distant spots are too fine for every second pixel: they move
  // single spots by some hundredths, either way.
  Vec2 sum;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vec2 off{double(found[i].x - expected[i].x), double(found[i].y - expected[i].y)};
    EXPECT_LT(norm(off), 0.05) << i;
    sum = sum + off;
  }
  EXPECT_LT(norm(sum) / double(found.size()), 0.01);
}

TEST_P(ColourCamera, FitsPositionsToItsLitPixels) {
  for (const int charge : {0, 1}) {
    const Vec2 at{62.27, 60.81};
    const auto tracker = make_position_fit({charge, kLambdaD, lit()}).value();
    TrackScratch scratch = tracker->make_scratch();
    const Packed image(filtered(spot_at(charge, at, full()), lit()), GetParam().format);
    const SpotFix fix = tracker->track(image.view, at + Vec2{2.0, -3.0}, scratch);
    ASSERT_TRUE(fix.found()) << charge;
    EXPECT_NEAR(fix.x, at.x, full() == 255 ? 0.05 : 0.02);
    EXPECT_NEAR(fix.y, at.y, full() == 255 ? 0.05 : 0.02);
  }
}

TEST_P(ColourCamera, NeedsSpotsWideEnoughForItsLitPixels) {
  EXPECT_TRUE(make_tracker({}, {1, 7.0, lit()}).has_value());
  const auto narrow = make_tracker({}, {1, 6.9, lit()});
  ASSERT_FALSE(narrow.has_value());
  EXPECT_EQ(narrow.error().field, "optics");
  EXPECT_NE(narrow.error().reason.find("colour"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(All, ColourCamera,
                         testing::Values(Colour{PixelFormat::bayer_rg8, kRedNm},
                                         Colour{PixelFormat::bayer_gr8, kRedNm},
                                         Colour{PixelFormat::bayer_gb10, kRedNm},
                                         Colour{PixelFormat::bayer_bg12, kRedNm},
                                         Colour{PixelFormat::bayer_rg12p, kRedNm},
                                         Colour{PixelFormat::bayer_gr10p, kGreenNm},
                                         Colour{PixelFormat::bayer_rg12, kGreenNm},
                                         Colour{PixelFormat::bayer_gb12p, kBlueNm},
                                         Colour{PixelFormat::bayer_gr12, kBlueNm}),
                         [](const auto& given) {
                           return std::string(pixel_format_name(given.param.format)) + "At" +
                                  std::to_string(int(given.param.wavelength_nm)) + "Nm";
                         });

}  // namespace
}  // namespace ovws
