#include "daemon/ovwsd/library/slm_measured.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/optics/zernike.hpp"
#include "daemon/ovwsd/library/origin.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

class Slm : public testing::Test {
 protected:
  Slm() { config_.slm.geometry = {160, 96, 19.0}; }
  HologramConfig configured() const {
    HologramConfig hologram;
    hologram.slm = config_.slm.geometry;
    return hologram;
  }
  BenchKey key(const HologramConfig& hologram) const {
    BenchKey key = test::key_of(config_);
    key.slm = slm_identity(hologram, false);
    key.flatness_file = flatness_sha256(hologram);
    return key;
  }
  nlohmann::json origin() const {
    return make_origin({key(configured()), {}, std::nullopt, std::nullopt, nullptr});
  }
  /// Whether a measurement applies to the configured bench, with this file in slm.flatness.
  template <class T>
  bool applies(const T& measured, respect::Set respects, const HologramConfig& hologram) const {
    return differing(respects, measured.key, key(hologram)) == 0;
  }
  bool applies(const MeasuredLut& lut) const { return applies(lut, respect::kLut, configured()); }
  bool applies(const MeasuredFlatness& flatness) const {
    return applies(flatness, respect::kFlatness, configured());
  }

  MeasuredLut lut() const {
    MeasuredLut lut;
    lut.t_taken_ns = 5;
    lut.frames = 3;
    lut.response.levels = 33;
    for (std::size_t g = 0; g < 256; ++g) {
      lut.response.phase_rad[g] = 5.6 * std::pow(double(g) / 255.0, 1.4);
      lut.response.standard_error_rad[g] = 1e-3 / 3.0;
    }
    lut.table = linearising_lut(lut.response.phase_rad);
    lut.key = key(configured());
    lut.origin = std::make_shared<const nlohmann::json>(origin());
    return lut;
  }
  MeasuredFlatness flatness() const {
    MeasuredFlatness flatness{7,  30,   4,  96.0, {{4, 0.25}, {7, -0.1}}, {1e-3, 2e-3},
                              {}, 4e-4, {}, {}};
    flatness.key = key(configured());
    flatness.origin = std::make_shared<const nlohmann::json>(origin());
    return flatness;
  }

  Config config_;
};

TEST_F(Slm, WhatWasMeasuredIsFoundAgainAsItWas) {
  const MeasuredLut table = lut();
  const auto found = lut_from(lut_content(table));
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_EQ(found->response.phase_rad, table.response.phase_rad);
  EXPECT_EQ(found->response.standard_error_rad, table.response.standard_error_rad);
  EXPECT_EQ(found->table.lut, table.table.lut);
  EXPECT_EQ(found->table.reason, table.table.reason);
  EXPECT_EQ(*found->origin, *table.origin);
  EXPECT_TRUE(applies(*found));
  const MeasuredFlatness surface = flatness();
  const auto flat = flatness_from(flatness_content(surface));
  ASSERT_TRUE(flat) << flat.error().reason;
  EXPECT_EQ(flat->modes, surface.modes);
  EXPECT_EQ(flat->standard_error_waves, surface.standard_error_waves);
  EXPECT_EQ(flat->pupil_diameter_px, 96.0);
  EXPECT_TRUE(applies(*flat));
}

TEST_F(Slm, WhatIsOfAnotherSlmOrWavelengthIsNotUsed) {
  const MeasuredLut table = lut();
  const MeasuredFlatness surface = flatness();
  config_.optics.wavelength_nm = 1064.0;
  EXPECT_FALSE(applies(table));
  config_.optics.wavelength_nm = 632.0;
  config_.slm.geometry.pitch_um = 8.0;
  EXPECT_FALSE(applies(surface));
  config_.slm.geometry.pitch_um = 19.0;
  EXPECT_TRUE(applies(surface));
}

TEST_F(Slm, AFlatnessIsAddedToTheMapThatItWasMeasuredWithOnly) {
  HologramConfig file = configured();
  file.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.125F);
  MeasuredFlatness surface = flatness();
  EXPECT_TRUE(applies(surface, respect::kFlatness, configured()));
  EXPECT_FALSE(applies(surface, respect::kFlatness, file));
  surface.key.flatness_file = flatness_sha256(file);
  surface = *flatness_from(flatness_content(surface));
  EXPECT_TRUE(applies(surface, respect::kFlatness, file));
  EXPECT_FALSE(applies(surface, respect::kFlatness, configured()));
  file.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.25F);
  EXPECT_FALSE(applies(surface, respect::kFlatness, file)) << "another map";
}

TEST_F(Slm, AFlatnessIsOfItsOpticsATableIsNot) {
  const MeasuredLut table = lut();
  const MeasuredFlatness surface = flatness();
  config_.optics.centre_px = Vec2{10.0, 10.0};
  EXPECT_TRUE(applies(surface)) << "where the spots are is the registration's";
  config_.optics.focal_length_mm = 150.0;
  EXPECT_FALSE(applies(surface));
  EXPECT_TRUE(applies(table));
}

TEST_F(Slm, ATableOfAPhaseThatFallsIsFoundAgain) {
  MeasuredLut table = lut();
  table.response.phase_rad = negative(table.response.phase_rad);
  table.table = linearising_lut(table.response.phase_rad);
  const auto found = lut_from(lut_content(table));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->response.falls());
  EXPECT_EQ(found->response.phase_rad, table.response.phase_rad);
  EXPECT_EQ(found->table.lut, table.table.lut);
}

TEST_F(Slm, AFileThatMeansNothingIsNotUsed) {
  MeasuredLut table = lut();
  table.response.phase_rad[100] = 0.0;  // falls
  EXPECT_FALSE(lut_from(lut_content(table)));
  MeasuredFlatness surface = flatness();
  surface.standard_error_waves.pop_back();
  EXPECT_FALSE(flatness_from(flatness_content(surface)));
}

TEST_F(Slm, AFineMapIsFoundAgainAndShown) {
  MeasuredFlatness surface = flatness();
  surface.fine = Image<float>(32, 32);
  for (float& waves : surface.fine.pixels) waves = 0.125F;
  surface.fine.at(0, 0) = std::numeric_limits<float>::quiet_NaN();
  nlohmann::json content = flatness_content(surface);
  const auto found = flatness_from(content);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->fine.width, 32);
  EXPECT_TRUE(std::isnan(found->fine.at(0, 0)));
  EXPECT_EQ(found->fine.at(5, 7), 0.125F);
  const auto without = active_slm(config_, configured(), nullptr,
                                  std::make_shared<const MeasuredFlatness>(flatness()));
  const auto with =
      active_slm(config_, configured(), nullptr, std::make_shared<const MeasuredFlatness>(*found));
  const int x = config_.slm.geometry.width_px / 2, y = config_.slm.geometry.height_px / 2;
  EXPECT_NEAR(without->hologram.flatness_waves->at(x, y) - with->hologram.flatness_waves->at(x, y),
              0.125, 1e-6);
  content["fine"]["cells"] = 33;
  EXPECT_FALSE(flatness_from(content));
}

TEST_F(Slm, TheHologramShowsTheOppositeOfTheError) {
  HologramConfig file = configured();
  file.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.125F);
  const auto slm = active_slm(config_, file, std::make_shared<const MeasuredLut>(lut()),
                              std::make_shared<const MeasuredFlatness>(flatness()));
  EXPECT_EQ(slm->hologram.lut, lut().table.lut);
  const Image<float>& map = *slm->hologram.flatness_waves;
  EXPECT_FLOAT_EQ(map.at(0, 0), 0.125F);  // outside the pupil
  for (const int x : {60, 79, 101}) {
    const double u = (x - 79.5) / 48.0, v = (40 - 47.5) / 48.0;
    const double error = 0.25 * zernike(4, {u, v}) - 0.1 * zernike(7, {u, v});
    EXPECT_NEAR(map.at(x, 40), 0.125 - error, 1e-5) << x;
  }
  EXPECT_NE(slm->identity, slm_identity(file, false));
  const auto cleared = active_slm(config_, file, nullptr, nullptr);
  EXPECT_EQ(cleared->identity, slm_identity(file, false));
  EXPECT_EQ(cleared->hologram.lut, linear_lut());
}

}  // namespace
}  // namespace ovws
