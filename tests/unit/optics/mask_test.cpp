#include "core/optics/mask.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/optics/hologram.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

std::shared_ptr<const Image<float>> ramp_map(int width, int height) {
  auto map = std::make_shared<Image<float>>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) map->at(x, y) = float(x) / float(width);
  }
  return map;
}

MaskConfig mask_in(std::vector<int> subapertures, std::vector<Mode> modes) {
  MaskConfig mask;
  mask.subapertures = std::move(subapertures);
  mask.modes = std::move(modes);
  return mask;
}

MaskConfig map_mask(std::shared_ptr<const Image<float>> map) {
  MaskConfig mask;
  mask.file = "ramp.txt";
  mask.sha256 = "checksum";
  mask.map = std::move(map);
  return mask;
}

TEST(Mask, AddsModesAConeAndAMap) {
  MaskConfig mask = map_mask(ramp_map(20, 20));
  mask.modes = {{4, 0.5}};
  mask.axicon_waves = 0.25;
  const Vec2 at{0.31, -0.4};
  const double cone = 0.25 * (std::hypot(at.x, at.y) - 2.0 / 3.0) / std::sqrt(1.0 / 18.0);
  EXPECT_NEAR(mask_waves(mask, at), 0.5 * zernike(4, at) + cone + 13.0 / 20.0, 1e-6);
}

TEST(Mask, AMapCoversTheSquareAroundASubaperture) {
  const MaskConfig mask = map_mask(ramp_map(16, 16));
  EXPECT_FLOAT_EQ(float(mask_waves(mask, {-1.0, 0.0})), 0.0F);
  EXPECT_FLOAT_EQ(float(mask_waves(mask, {1.0, 0.0})), 15.0F / 16.0F);
  EXPECT_FLOAT_EQ(float(mask_waves(mask, {0.01, 0.9})), 8.0F / 16.0F);
}

TEST(Mask, AMapOfTheWrongSizeIsRefused) {
  for (const auto& map : {ramp_map(16, 17), ramp_map(15, 15), ramp_map(2049, 2049)}) {
    const auto checked = check_masks({map_mask(map)}, 19);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().field, "sensor.mask.file");
    EXPECT_NE(checked.error().reason.find(std::to_string(map->width)), std::string::npos);
  }
  auto broken = std::make_shared<Image<float>>(16, 16);
  broken->at(3, 4) = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(check_masks({map_mask(broken)}, 19));
  EXPECT_FALSE(check_masks({map_mask(nullptr)}, 19));
  EXPECT_TRUE(check_masks({map_mask(ramp_map(16, 16))}, 19));
}

TEST(Mask, AModeOutOfRangeIsRefused) {
  MaskConfig mask;
  mask.modes = {{kMaxZernikeIndex + 1, 0.1}};
  EXPECT_EQ(check_masks({mask}, 19).error().field, "sensor.mask.modes");
  mask.modes = {{3, 11.0}};
  EXPECT_EQ(check_masks({mask}, 19).error().field, "sensor.mask.modes");
}

TEST(Mask, ASubapertureHasTheSumOfTheMasksThatNameIt) {
  Masks masks{mask_in({}, {{4, 0.1}}), mask_in({2, 5}, {}), mask_in({5}, {{3, -0.3}})};
  masks[1].axicon_waves = 0.2;
  const Vec2 at{0.3, -0.5};
  const double all = mask_waves(masks[0], at), some = mask_waves(masks[1], at);
  EXPECT_DOUBLE_EQ(mask_waves(masks, 0, at), all);
  EXPECT_DOUBLE_EQ(mask_waves(masks, 2, at), all + some);
  EXPECT_DOUBLE_EQ(mask_waves(masks, 5, at), all + some + mask_waves(masks[2], at));
}

TEST(Mask, TooManyOrTooLargeMapsAreRefused) {
  EXPECT_TRUE(check_masks(Masks(kMaxMasks), 19));
  EXPECT_EQ(check_masks(Masks(kMaxMasks + 1), 19).error().field, "sensor.mask");
  const auto large = [] { return map_mask(ramp_map(kMaxMaskPx, kMaxMaskPx)); };
  Masks four{large(), large(), large(), large()};
  EXPECT_TRUE(check_masks(four, 19));
  four.push_back(four.front());  // shares its map
  EXPECT_TRUE(check_masks(four, 19));
  four.push_back(map_mask(ramp_map(16, 16)));
  EXPECT_EQ(check_masks(four, 19).error().field, "sensor.mask");
}

TEST(Mask, TheModesOfASubapertureAreBounded) {
  const std::vector<Mode> many(23, {4, 0.01});
  EXPECT_TRUE(check_masks({mask_in({0, 1}, many), mask_in({2, 3}, many)}, 4));
  EXPECT_EQ(check_masks({mask_in({0, 1}, many), mask_in({1, 2}, many)}, 4).error().field,
            "sensor.mask[1].modes");
  EXPECT_EQ(check_masks({mask_in({}, many), mask_in({}, many)}, 4).error().field,
            "sensor.mask[1].modes");
}

TEST(Mask, FilesAreComparedByContent) {
  MaskConfig mask = map_mask(ramp_map(16, 16)), same = mask;
  same.file = "copy.txt";
  EXPECT_EQ(mask, same);
  same.sha256 = "other";
  EXPECT_NE(mask, same);
}

TEST(Mask, ANamedFileTakesTheMapInUse) {
  const Masks in_use{mask_in({}, {{4, 0.1}}), map_mask(ramp_map(16, 16))};
  Masks named(2);
  named[0].file = "another.txt";
  named[1].file = "ramp.txt";
  adopt_maps(named, in_use);
  EXPECT_EQ(named[0].map, nullptr);
  EXPECT_EQ(named[1].map, in_use[1].map);
  EXPECT_EQ(named[1], in_use[1]);
}

TEST(Mask, EverySubapertureImprintsItAroundItsCentre) {
  HologramConfig plain, masked;
  masked.sensor.masks.emplace_back().modes = {{0, 0.25}};  // piston: a quarter of the grey levels
  const auto without = HologramRenderer::make(plain), with = HologramRenderer::make(masked);
  ASSERT_TRUE(without && with);
  Image<std::uint8_t> a, b;
  without->render(HologramKind::sensor, {}, a);
  with->render(HologramKind::sensor, {}, b);
  for (const Subaperture& s : with->lattice().subapertures) {
    const int x = int(std::lround(639.5 + s.centre_px.x)) + 20;
    const int y = int(std::lround(383.5 + s.centre_px.y)) - 10;
    EXPECT_NEAR(std::uint8_t(b.at(x, y) - a.at(x, y)), 64, 1);
  }
  EXPECT_EQ(a.at(2, 2), b.at(2, 2));
}

TEST(Lattice, SecondSubaperturesHaveTheAlternateCharge) {
  for (const Grid grid : {Grid::square, Grid::hexagonal}) {
    SensorConfig sensor;
    sensor.grid = grid;
    sensor.charge = 2;
    sensor.alternate_charge = -2;
    const auto lattice = make_lattice(sensor, {});
    ASSERT_TRUE(lattice);
    for (const Subaperture& one : lattice->subapertures) {
      if (norm(one.centre_px) < 1.0) {
        EXPECT_EQ(one.charge, 2);
      }
      for (const Subaperture& other : lattice->subapertures) {
        const Vec2 away = other.centre_px - one.centre_px;
        if (norm(away) < 1.0 || norm(away) > 1.01 * lattice->diameter_px) continue;
        const bool same_row = std::abs(away.y) < 1.0;
        EXPECT_EQ(one.charge == other.charge, grid == Grid::hexagonal && same_row);
      }
    }
  }
}

TEST(Lattice, ChargesAreOnePerSubaperture) {
  SensorConfig sensor;
  for (int i = 0; i < 19; ++i) sensor.charges.push_back(i % 4 - 1);
  const auto lattice = make_lattice(sensor, {});
  ASSERT_TRUE(lattice);
  EXPECT_EQ(charges_of(*lattice), sensor.charges);
  sensor.alternate_charge = 0;
  EXPECT_EQ(make_lattice(sensor, {}).error().field, "sensor.charges");
  sensor.alternate_charge.reset();
  sensor.charges.pop_back();
  EXPECT_EQ(make_lattice(sensor, {}).error().field, "sensor.charges");
}

TEST(Hologram, MasksOnlyTheNamedSubapertures) {
  SensorConfig sensor;
  MaskConfig& mask = sensor.masks.emplace_back();
  mask.subapertures = {3, 18};
  mask.axicon_waves = 0.25;
  HologramConfig masked, plain;
  masked.sensor = sensor;
  const auto with = HologramRenderer::make(masked), without = HologramRenderer::make(plain);
  ASSERT_TRUE(with && without);
  Image<std::uint8_t> a, b;
  without->render(HologramKind::sensor, {}, a);
  with->render(HologramKind::sensor, {}, b);
  for (int i = 0; i < 19; ++i) {
    const Vec2 centre = with->lattice().subapertures[std::size_t(i)].centre_px;
    const int x = int(std::lround(639.5 + centre.x)) + 70, y = int(std::lround(383.5 + centre.y));
    EXPECT_EQ(a.at(x, y) != b.at(x, y), i == 3 || i == 18) << i;
  }
  mask.subapertures = {19};
  EXPECT_EQ(make_lattice(sensor, {}).error().field, "sensor.mask.subapertures");
  mask.subapertures = {0};
  sensor.masks.push_back(mask_in({18, -1}, {}));
  EXPECT_EQ(make_lattice(sensor, {}).error().field, "sensor.mask[1].subapertures");
}

TEST(Lattice, AllSubaperturesHaveTheCharge) {
  SensorConfig sensor;
  sensor.charge = 3;
  const auto lattice = make_lattice(sensor, {});
  ASSERT_TRUE(lattice);
  for (const Subaperture& one : lattice->subapertures) EXPECT_EQ(one.charge, 3);
}

}  // namespace
}  // namespace ovws
