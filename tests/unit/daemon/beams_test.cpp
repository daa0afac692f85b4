/// Several light sources: which configurations are accepted, and which reference is whose.
#include "daemon/ovwsd/sensor/beams.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

Config bench_with(std::vector<BeamConfig> beams) {
  Config config;
  config.camera.settings.roi = {0, 0, 512, 1344};
  config.optics.centre_px = Vec2{255.5, 255.5};
  config.beams = std::move(beams);
  return config;
}

/// The refusal's field and reason; empty if it is accepted.
std::string beams_refusal(const Config& config) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  const auto checked = check_beams(spot_bench(config, *lattice), config.beams);
  return checked ? "" : checked.error().field + ": " + checked.error().reason;
}

TEST(Beams, InRegionsOfTheirOwnAreAccepted) {
  EXPECT_EQ(beams_refusal(bench_with({})), "");
  EXPECT_EQ(beams_refusal(bench_with({{"b", {0, 420}}, {"c", {10, 840}}})), "");
}

TEST(Beams, ThatOverlapAreRefusedWithADistanceThatWorks) {
  const std::string near_main = beams_refusal(bench_with({{"b", {0, 200}}}));
  EXPECT_TRUE(near_main.starts_with("beams[0].offset_px: ")) << near_main;
  EXPECT_NE(near_main.find("overlap those of the main source"), std::string::npos) << near_main;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(near_main, found, std::regex("at least ([0-9]+) px")));
  const double least_px = std::stod(found[1]);
  EXPECT_EQ(beams_refusal(bench_with({{"b", {0, least_px}}})), "");
  EXPECT_NE(beams_refusal(bench_with({{"b", {0, least_px - 2}}})), "");

  const std::string near_b = beams_refusal(bench_with({{"b", {0, 420}}, {"c", {0, 700}}}));
  EXPECT_TRUE(near_b.starts_with("beams[1].offset_px: ")) << near_b;
  EXPECT_NE(near_b.find("overlap those of the source b"), std::string::npos) << near_b;
}

TEST(Beams, OutsideTheCamerasRegionAreRefused) {
  const std::string outside = beams_refusal(bench_with({{"b", {0, 1200}}}));
  EXPECT_TRUE(outside.starts_with("beams[0].offset_px: ")) << outside;
  EXPECT_NE(outside.find("outside the camera's region"), std::string::npos) << outside;
}

TEST(Beams, AreSearchedInCirclesThatDoNotOverlap) {
  const std::vector<Vec2> spots{{100, 100}, {140, 100}, {120, 80}, {120, 120}};
  EXPECT_TRUE(search_regions(spots, {}).empty());
  const auto regions = search_regions(spots, {{"b", {0, 200}}, {"c", {0, 500}}});
  ASSERT_EQ(regions.size(), 3U);
  EXPECT_EQ(regions[0].centre, (Vec2{120, 100}));
  EXPECT_EQ(regions[0].radius, 100.0);
  EXPECT_EQ(regions[1].radius, 100.0);
  EXPECT_EQ(regions[2].centre, (Vec2{120, 600}));
  EXPECT_EQ(regions[2].radius, 150.0);
}

TEST(Beams, HaveTheirPartOfAMeasuredReferenceWhileTheOffsetIsTheSame) {
  Reference all;
  all.t_taken_ns = 1;
  all.positions_px = {{1, 1}};
  all.standard_error_px = {{0, 0}};
  all.beams = {{{20, 2, {{3, 0.1}}, {}, {{1, 6}}, {{0.1, 0.1}}}, "b", {0, 5}}};
  const auto own = reference_of(all, {"b", {0, 5}}, {});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->t_taken_ns, 2);
  EXPECT_EQ(own->positions_px, (std::vector<Vec2>{{1, 6}}));
  EXPECT_EQ(own->aberration, (std::vector<Mode>{{3, 0.1}}));
  EXPECT_FALSE(reference_of(all, {"b", {0, 6}}, {}));
  EXPECT_FALSE(reference_of(all, {"c", {0, 5}}, {}));
}

TEST(Beams, OfAModelReferenceAreTheModelDisplaced) {
  Reference model;
  model.source = ReferenceSource::model;
  model.positions_px = {{1, 1}, {2, 2}};
  const auto own = reference_of(model, {"b", {0, 5}}, {{10, 10}, {20, 20}});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->positions_px, (std::vector<Vec2>{{10, 15}, {20, 25}}));
}

}  // namespace
}  // namespace ovws
