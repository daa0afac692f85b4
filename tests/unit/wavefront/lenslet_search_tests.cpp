/// A lenslet array is found in one image of its spots.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "core/tracking/spot_geometry.hpp"
#include "core/wavefront/lenslet_search.hpp"
#include "core/wavefront/registration.hpp"

namespace ovws {
namespace {

constexpr double kSpotPx = 3.6;  // lambda/d of 150 um lenslets, f = 5.2 mm, on pixels of 5.3 um

/// Intensity of a spot at a radius in lambda/d, from a table.
double intensity(int charge, double radius) {
  constexpr double kStep = 0.01;
  static std::map<int, std::vector<double>> tables;
  std::vector<double>& table = tables[charge];
  for (int k = int(table.size()); k < 700; ++k) table.push_back(spot_intensity(charge, k * kStep));
  const auto k = std::size_t(radius / kStep);
  return k + 1 < table.size() ? table[k] : 0.0;
}

/// Spots of an array on a camera of 640 x 512 pixels, DN.
struct ArrayImage {
  Grid grid = Grid::square;
  int charge = 0;
  double pitch_px = 28.3, rotation_deg = 1.3;
  Vec2 middle_px{320.4, 255.8};
  double defocus_px = 0.0;      ///< displacement at 200 pixels from the middle
  double astigmatism_px = 0.0;  ///< the same, oblique
  double noise_dn = 1.0;
  unsigned seed = 7;
  double stray_dn = 0.0;  ///< from one side of the image to the other
  std::function<double(Vec2)> light = [](Vec2) { return 1.0; };  ///< at the place from the middle

  std::vector<Vec2> places() const {
    std::vector<Vec2> all;
    const double turn = rotation_deg * std::numbers::pi / 180.0;
    for (int b = -20; b <= 20; ++b) {
      for (int a = -30; a <= 30; ++a) {
        const bool hexagonal = grid == Grid::hexagonal;
        const double x = pitch_px * (a + (hexagonal ? 0.5 * b : 0.0));
        const double y = pitch_px * b * (hexagonal ? std::sqrt(0.75) : 1.0);
        all.push_back(
            {x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn)});
      }
    }
    return all;
  }
  Image<float> render() const {
    Image<float> image(640, 512, 3.0F);
    for (const Vec2 place : places()) {
      const double peak = 150.0 * light(place);
      const Vec2 across{place.y, place.x};
      const Vec2 at =
          middle_px + (1.0 + defocus_px / 200.0) * place + (astigmatism_px / 200.0) * across;
      const int reach = 13;
      for (int y = int(at.y) - reach; y <= int(at.y) + reach; ++y) {
        for (int x = int(at.x) - reach; x <= int(at.x) + reach; ++x) {
          if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
          const double r = norm(Vec2{double(x), double(y)} - at) / kSpotPx;
          const double scale = charge == 0 ? 4.0 : 18.0;
          image.at(x, y) += float(peak * scale * intensity(charge, r));
        }
      }
    }
    std::mt19937 random(seed);
    std::normal_distribution<float> noise(0.0F, float(noise_dn));
    for (std::size_t k = 0; k < image.pixels.size(); ++k) {
      const double across = double(k % std::size_t(image.width)) / image.width;
      image.pixels[k] += noise(random) + float(stray_dn * across);
    }
    return image;
  }
  LensletSearch search() const { return {grid, 28.3, {charge, kSpotPx}}; }
};

TEST(LensletSearch, FindsPitchRotationAndPlaces) {
  for (const Grid grid : {Grid::square, Grid::hexagonal}) {
    for (const int charge : {0, 1}) {
      const ArrayImage array{.grid = grid, .charge = charge};
      const auto map = find_lenslets(array.render(), array.search());
      ASSERT_TRUE(map) << map.error().reason;
      EXPECT_NEAR(map->pitch_px, 28.3, 0.005);
      EXPECT_NEAR(map->rotation_deg, 1.3, 0.01);
      EXPECT_LT(map->residual_px, 0.1);
      EXPECT_GT(map->lit(), grid == Grid::square ? 350 : 400);
      for (const LensletNode& node : map->nodes) {
        if (!node.lit) continue;
        double nearest = 1e9;
        for (const Vec2 place : array.places()) {
          nearest = std::min(nearest, norm(array.middle_px + place - node.at_px));
        }
        EXPECT_LT(nearest, 0.05);
      }
    }
  }
}

TEST(LensletSearch, RoundBeamGivesItsPupil) {
  ArrayImage array;
  array.light = [](Vec2 at) { return norm(at) < 170.0 && norm(at) > 40.0 ? 1.0 : 0.02; };
  array.defocus_px = 8.0;
  const auto map = find_lenslets(array.render(), array.search());
  ASSERT_TRUE(map) << map.error().reason;
  const LensletPupil pupil = lenslet_pupil(*map, std::nullopt);
  EXPECT_LT(norm(pupil.centre_px - array.middle_px), 3.0);
  EXPECT_NEAR(pupil.diameter_px, 340.0, 28.3);
  EXPECT_GT(pupil.centres_px.size(), 70U);  // of 101, without the dark ones in the middle
  EXPECT_LT(pupil.centres_px.size(), 110U);
  const LensletPupil smaller = lenslet_pupil(*map, 200.0);
  EXPECT_EQ(smaller.diameter_px, 200.0);
  EXPECT_LT(smaller.centres_px.size(), pupil.centres_px.size());
}

/// An iris cuts lenslets at the rim: their light is that of the part inside, squared in the peak.
double behind_iris(Vec2 at, double radius_px, double pitch_px) {
  constexpr int kSide = 20;
  int inside = 0;
  for (int k = 0; k < kSide * kSide; ++k) {
    const Vec2 part{(k % kSide + 0.5) / kSide - 0.5, (k / kSide + 0.5) / kSide - 0.5};
    inside += norm(at + pitch_px * part) < radius_px ? 1 : 0;
  }
  const double share = double(inside) / (kSide * kSide);
  return share * share;
}

FoundArray found_as(const LensletPupil& pupil, const LensletMap& map) {
  FoundArray array;
  array.pupil_diameter_px = pupil.diameter_px;
  array.lenslets.width_px = map.pitch_px;
  array.lenslets.centres_px = pupil.centres_px;
  return array;
}

TEST(LensletSearch, NoiseAndStrayLightDoNotMoveThePupilBehindAnIris) {
  for (const int charge : {0, 1}) {
    for (const double radius_px : {199.0, 202.0, 205.0, 208.0, 211.0, 214.0}) {
      std::vector<FoundArray> found;
      for (unsigned seed = 1; seed <= 6; ++seed) {
        ArrayImage array{.charge = charge, .rotation_deg = 0.0, .seed = seed};
        array.stray_dn = 10.0 * (seed % 2);
        array.light = [&](Vec2 at) { return behind_iris(at, radius_px, array.pitch_px); };
        const auto map = find_lenslets(array.render(), array.search());
        ASSERT_TRUE(map) << map.error().reason;
        EXPECT_LT(map->pitch_error_px, 0.003);
        EXPECT_LT(std::abs(map->pitch_px - 28.3), 4.0 * map->pitch_error_px + 1e-3);
        const LensletPupil pupil = lenslet_pupil(*map, std::nullopt);
        EXPECT_LT(norm(pupil.centre_px - array.middle_px), 0.02 * array.pitch_px) << radius_px;
        EXPECT_NEAR(pupil.diameter_px, 2.0 * radius_px, array.pitch_px) << radius_px;
        found.push_back(found_as(pupil, *map));
        EXPECT_TRUE(shift_if_same(found[0], found.back())) << radius_px;
      }
    }
  }
}

TEST(LensletSearch, UnevenLightHardlyMovesThePupilBehindAnIris) {
  struct Case {
    std::function<double(Vec2)> profile;
    double most_pitches;  ///< that the centre may be off
  };
  const auto slope = [](double part) {
    return [part](Vec2 at) { return 1.0 + part * at.x / 200.0; };
  };
  const auto beam = [](double off_px) {
    return [off_px](Vec2 at) {
      const double away = norm(at - Vec2{off_px, 0.0}) / 240.0;
      return std::exp(-2.0 * away * away);
    };
  };
  const auto half = [](Vec2 at) { return at.x < -5.0 ? 0.35 : 1.0; };
  const std::vector<Case> cases{{slope(0.1), 0.02}, {slope(0.2), 0.02}, {slope(0.5), 0.05},
                                {beam(0.0), 0.02},  {beam(20.0), 0.05}, {beam(40.0), 0.12},
                                {half, 0.05}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    for (const double radius_px : {199.0, 205.0, 211.0}) {
      ArrayImage array{.rotation_deg = 0.0, .noise_dn = 0.2};
      array.light = [&](Vec2 at) {
        return behind_iris(at, radius_px, array.pitch_px) * cases[k].profile(at);
      };
      const auto map = find_lenslets(array.render(), array.search());
      ASSERT_TRUE(map) << map.error().reason;
      const LensletPupil pupil = lenslet_pupil(*map, std::nullopt);
      EXPECT_LT(norm(pupil.centre_px - array.middle_px), cases[k].most_pitches * array.pitch_px)
          << k << " " << radius_px;
      EXPECT_NEAR(pupil.diameter_px, 2.0 * radius_px, array.pitch_px) << k << " " << radius_px;
    }
  }
}

TEST(LensletSearch, ABentLatticeKeepsItsPupil) {
  for (const double bend : {0.0, 0.05, 0.1, 0.15}) {
    ArrayImage array{.rotation_deg = 0.0};
    array.light = [&](Vec2 at) { return behind_iris(at, 165.0, array.pitch_px); };
    array.astigmatism_px = 200.0 * bend;
    const auto map = find_lenslets(array.render(), array.search());
    ASSERT_TRUE(map) << map.error().reason;
    const LensletPupil pupil = lenslet_pupil(*map, std::nullopt);
    EXPECT_LT(norm(pupil.centre_px - array.middle_px), 0.05 * array.pitch_px) << bend;
    EXPECT_NEAR(pupil.diameter_px, 330.0, array.pitch_px) << bend;
  }
}

/// Lenslets 10 pixels apart, whose centres are less than 41 pixels from `centre`.
FoundArray array_about(Vec2 centre, double scale = 1.0) {
  FoundArray array;
  array.pupil_diameter_px = 92.0;
  array.lenslets.width_px = 10.0;
  for (int k = 0; k < 121; ++k) {
    const Vec2 at = scale * Vec2{10.0 * (k % 11 - 5), 10.0 * (k / 11 - 5)} - centre;
    if (norm(at) < 41.0) array.lenslets.centres_px.push_back(at);
  }
  return array;
}

TEST(LensletSearch, LensletsThatNoiseMovesAreTheSame) {
  const FoundArray now = array_about({0.0, 0.0}), next = array_about({0.2, -0.1});
  const auto shift = shift_if_same(now, next);
  ASSERT_TRUE(shift);
  EXPECT_LT(norm(*shift - Vec2{0.2, -0.1}), 1e-12);
  FoundArray others = now;  // one at the rim more
  others.lenslets.centres_px.push_back({-40.0, 10.0});
  EXPECT_TRUE(shift_if_same(now, others));
  EXPECT_TRUE(shift_if_same(others, now));
  EXPECT_FALSE(shift_if_same(now, array_about({1.0, 0.0})));
  EXPECT_FALSE(shift_if_same(now, array_about({0.0, 0.0}, 1.003))) << "another pitch";
  FoundArray wider = now, without = now;
  wider.pupil_diameter_px += 2.0;
  EXPECT_FALSE(shift_if_same(now, wider));
  without.lenslets.centres_px.erase(without.lenslets.centres_px.begin() + 24);
  EXPECT_FALSE(shift_if_same(now, without)) << "a lenslet inside";
  EXPECT_FALSE(shift_if_same(without, now));
}

TEST(LensletSearch, RefusesWhatItDoesNotKnow) {
  const ArrayImage array;
  const Image<float> image = array.render();
  LensletSearch search = array.search();
  search.pitch_px = 35.0;
  EXPECT_EQ(find_lenslets(image, search).error().field, "array.pitch_um");
  search = array.search();
  search.grid = Grid::hexagonal;
  EXPECT_EQ(find_lenslets(image, search).error().field, "sensor.grid");
  EXPECT_EQ(find_lenslets(Image<float>(640, 512, 3.0F), array.search()).error().field, "camera");
  ArrayImage dark;
  dark.light = [](Vec2 at) { return norm(at) < 20.0 ? 1.0 : 0.0; };
  EXPECT_EQ(find_lenslets(dark.render(), dark.search()).error().field, "camera");
}

}  // namespace
}  // namespace ovws
