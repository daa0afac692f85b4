// Measured spot shapes in files: what is written is read, and damaged shapes are refused.
#include "daemon/ovwsd/library/shapes_file.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ovws {
namespace {

using nlohmann::json;

MeasuredShapes shapes_with(const LitPixels& lit) {
  MeasuredShapes shapes{{1, 2}, {}, {0.03, 0.015}, {{21, -0.1}}};
  for (int i = 0; i < 2; ++i) {
    RenderedSpot& spot = shapes.spots.emplace_back();
    spot.window = window_of(12.0, 2.0, lit);
    spot.window.left = 10 * i, spot.window.top = 3;
    spot.place_px = {10.0 * i + 24.25, 27.5};
    spot.light = Eigen::VectorXf::LinSpaced(spot.window.cells(), 0.0F, 1.0F);
    spot.per_wave = Eigen::MatrixXf::Constant(spot.window.cells(), 2, 0.1F);
    spot.per_px = Eigen::MatrixXf::Constant(spot.window.cells(), 2, -0.3F);
  }
  return shapes;
}

TEST(ShapesFile, HoldsTheShapesAndTheirLitPixels) {
  for (const LitPixels& lit :
       {LitPixels{}, LitPixels{{2, 0, 1}, false}, LitPixels{{2, 1, 0}, true}}) {
    const MeasuredShapes shapes = shapes_with(lit);
    const auto read = shapes_from(shapes_content(shapes), 2, {1, 2});
    ASSERT_TRUE(read) << read.error().reason;
    EXPECT_EQ(read->lit(), lit);
    EXPECT_EQ(read->modes_j, shapes.modes_j);
    EXPECT_EQ(read->poke_waves, shapes.poke_waves);
    EXPECT_EQ(read->fixed, shapes.fixed);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(read->spots[i].window, shapes.spots[i].window);
      EXPECT_EQ(read->spots[i].light, shapes.spots[i].light);
      EXPECT_EQ(read->spots[i].per_wave, shapes.spots[i].per_wave);
      EXPECT_EQ(read->spots[i].per_px, shapes.spots[i].per_px);
    }
  }
}

TEST(ShapesFile, WithImpossiblePokesIsRefused) {
  const json good = shapes_content(shapes_with({}));
  for (const auto& [key, value] : {std::pair{"poke_waves", json{0.03}},
                                   {"poke_waves", json{0.03, 0.0}},
                                   {"poke_waves", json{0.03, 1.0}},
                                   {"poke_waves", json{0.03, nullptr}},
                                   {"fixed", json::array({{{"j", -1}, {"waves", 0.1}}})},
                                   {"fixed", json::array({{{"j", 21}, {"waves", 1e9}}})},
                                   {"fixed", json(5)}}) {
    json content = good;
    content[key] = value;
    EXPECT_FALSE(shapes_from(content, 2, {1, 2})) << key << " " << value;
  }
}

TEST(ShapesFile, WithImpossiblePixelsIsRefused) {
  const json good = shapes_content(shapes_with({{2, 0, 1}, false}));
  for (const auto& [key, value] : {std::pair{"step", 3}, {"step", 0}, {"x", 2}, {"y", -1}}) {
    json content = good;
    content["lit"][key] = value;
    EXPECT_FALSE(shapes_from(content, 2, {1, 2})) << key << " " << value;
  }
  json binned = good;
  binned["bin"] = 2;
  EXPECT_FALSE(shapes_from(binned, 2, {1, 2}));
}

}  // namespace
}  // namespace ovws
