#include "daemon/ovwsd/slm/slm_measured.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/optics/zernike.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

class Slm : public testing::Test {
 protected:
  Slm() { config_.slm.geometry = {160, 96, 19.0}; }
  void TearDown() override { fs::remove_all(folder_); }

  /// The part of a daemon, just started with this configuration, that keeps LUT and flatness.
  struct Started {
    Started(const Config& config, const HologramConfig& configured, const std::string& folder)
        : store({folder}, events),
          luts(LutKind{config}, store, events),
          flatnesses(FlatnessKind{config, flatness_sha256(configured)}, store, events) {}
    StreamQueue queue;
    Events events{queue};
    DaemonStore store;
    Kept<LutKind> luts;
    Kept<FlatnessKind> flatnesses;

    std::shared_ptr<const MeasuredLut> load_lut() {
      const auto all = luts.load();
      return all.empty() ? nullptr : all.back();
    }
    std::shared_ptr<const MeasuredFlatness> load_flatness() {
      const auto all = flatnesses.load();
      return all.empty() ? nullptr : all.back();
    }
  };
  std::unique_ptr<Started> started() const {
    return std::make_unique<Started>(config_, configured(), folder_);
  }

  HologramConfig configured() const {
    HologramConfig hologram;
    hologram.slm = config_.slm.geometry;
    return hologram;
  }
  nlohmann::json origin() const {
    const ReferenceKey key = reference_key(config_.sensor, config_.tracking, Roi{});
    return ReferenceBench(config_, configured())
        .origin({key, {}, std::nullopt, std::nullopt, std::nullopt, nullptr});
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
    lut.origin = origin();
    return lut;
  }
  MeasuredFlatness flatness() const {
    MeasuredFlatness flatness{7,    30,      4,  96.0, {{4, 0.25}, {7, -0.1}}, {1e-3, 2e-3}, {},
                              4e-4, nullptr, {}, ""};
    flatness.origin = origin();
    return flatness;
  }

  Config config_;
  const std::string folder_ = own_folder("slm_archive");
};

TEST_F(Slm, WhatWasMeasuredIsFoundAgainAsItWas) {
  MeasuredLut table = lut();
  MeasuredFlatness surface = flatness();
  {
    const auto daemon = started();
    daemon->luts.keep(table, {}, [&](const std::string& sha256) { table.sha256 = sha256; });
    daemon->flatnesses.keep(surface);
  }
  const auto daemon = started();
  const auto found = daemon->load_lut();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->response.phase_rad, table.response.phase_rad);
  EXPECT_EQ(found->response.standard_error_rad, table.response.standard_error_rad);
  EXPECT_EQ(found->table.lut, table.table.lut);
  EXPECT_EQ(found->table.reason, table.table.reason);
  EXPECT_EQ(found->origin, table.origin);
  EXPECT_FALSE(table.sha256.empty());
  EXPECT_EQ(found->sha256, table.sha256);
  const auto flat = daemon->load_flatness();
  ASSERT_TRUE(flat);
  EXPECT_EQ(flat->modes, surface.modes);
  EXPECT_EQ(flat->standard_error_waves, surface.standard_error_waves);
  EXPECT_EQ(flat->pupil_diameter_px, 96.0);
  daemon->luts.drop({"slm"}, [](const Result<void>& dropped) { EXPECT_TRUE(dropped); });
  EXPECT_FALSE(daemon->load_lut());
  EXPECT_TRUE(daemon->load_flatness());
}

TEST_F(Slm, WhatIsOfAnotherSlmOrWavelengthIsNotUsed) {
  MeasuredLut table = lut();
  MeasuredFlatness surface = flatness();
  started()->luts.keep(table);
  started()->flatnesses.keep(surface);
  config_.optics.wavelength_nm = 1064.0;
  EXPECT_FALSE(started()->load_lut());
  config_.optics.wavelength_nm = 632.0;
  config_.slm.geometry.pitch_um = 8.0;
  EXPECT_FALSE(started()->load_flatness());
  config_.slm.geometry.pitch_um = 19.0;
  EXPECT_TRUE(started()->load_flatness());
}

TEST_F(Slm, AFlatnessIsAddedToTheMapThatItWasMeasuredWithOnly) {
  HologramConfig file = configured();
  file.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.125F);
  const auto found_with = [&](const HologramConfig& hologram) {
    return bool(Started(config_, hologram, folder_).load_flatness());
  };
  MeasuredFlatness surface = flatness();
  started()->flatnesses.keep(surface);
  EXPECT_TRUE(found_with(configured()));
  EXPECT_FALSE(found_with(file));
  surface.configured_sha256 = flatness_sha256(file);
  started()->flatnesses.keep(surface);
  EXPECT_TRUE(found_with(file));
  EXPECT_FALSE(found_with(configured()));
  file.flatness_waves = std::make_shared<Image<float>>(160, 96, 0.25F);
  EXPECT_FALSE(found_with(file)) << "another map";
}

TEST_F(Slm, AFlatnessIsOfItsOpticsATableIsNot) {
  MeasuredLut table = lut();
  MeasuredFlatness surface = flatness();
  started()->luts.keep(table);
  started()->flatnesses.keep(surface);
  config_.optics.centre_px = Vec2{10.0, 10.0};
  EXPECT_TRUE(started()->load_flatness()) << "where the spots are is the registration's";
  config_.optics.focal_length_mm = 150.0;
  EXPECT_FALSE(started()->load_flatness());
  EXPECT_TRUE(started()->load_lut());
}

TEST_F(Slm, ATableOfAPhaseThatFallsIsFoundAgain) {
  MeasuredLut table = lut();
  table.response.phase_rad = negative(table.response.phase_rad);
  table.table = linearising_lut(table.response.phase_rad);
  started()->luts.keep(table);
  const auto found = started()->load_lut();
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->response.falls());
  EXPECT_EQ(found->response.phase_rad, table.response.phase_rad);
  EXPECT_EQ(found->table.lut, table.table.lut);
}

TEST_F(Slm, AFileThatMeansNothingIsNotUsed) {
  MeasuredLut table = lut();
  table.response.phase_rad[100] = 0.0;  // falls
  started()->luts.keep(table);
  EXPECT_FALSE(started()->load_lut());
  MeasuredFlatness surface = flatness();
  surface.standard_error_waves.pop_back();
  started()->flatnesses.keep(surface);
  EXPECT_FALSE(started()->load_flatness());
}

TEST_F(Slm, AFineMapIsFoundAgainAndShown) {
  MeasuredFlatness surface = flatness();
  surface.fine = Image<float>(32, 32);
  for (float& waves : surface.fine.pixels) waves = 0.125F;
  surface.fine.at(0, 0) = std::numeric_limits<float>::quiet_NaN();
  started()->flatnesses.keep(surface);
  const auto found = started()->load_flatness();
  ASSERT_TRUE(found);
  ASSERT_EQ(found->fine.width, 32);
  EXPECT_TRUE(std::isnan(found->fine.at(0, 0)));
  EXPECT_EQ(found->fine.at(5, 7), 0.125F);
  const auto without = active_slm(config_, configured(), nullptr,
                                  std::make_shared<const MeasuredFlatness>(flatness()));
  const auto with = active_slm(config_, configured(), nullptr, found);
  const int x = config_.slm.geometry.width_px / 2, y = config_.slm.geometry.height_px / 2;
  EXPECT_NEAR(without->hologram.flatness_waves->at(x, y) - with->hologram.flatness_waves->at(x, y),
              0.125, 1e-6);
  nlohmann::json content = FlatnessKind{config_, nullptr}.content(surface);
  content["fine"]["cells"] = 33;
  EXPECT_FALSE((FlatnessKind{config_, nullptr}.read(content)));
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
