#include "daemon/ovws/text/mode_names.hpp"

#include <gtest/gtest.h>

namespace ovws::cli {
namespace {

TEST(ModesText, ModesAreReadInOrder) {
  const auto modes = parse_modes("2, -2 : 0.5; 4 ,0 :-0.1", ZernikeNorm::rms);
  ASSERT_TRUE(modes);
  EXPECT_EQ(*modes, (std::vector<Mode>{{3, 0.5}, {12, -0.1}}));
}

TEST(ModesText, NothingIsNoModes) {
  EXPECT_TRUE(parse_modes("", ZernikeNorm::rms)->empty());
  EXPECT_EQ(parse_modes("2,0:0.1;", ZernikeNorm::rms)->size(), 1U);
}

TEST(ModesText, UnitAmplitudeIsTurnedIntoRms) {
  const auto modes = parse_modes("2,-2:2.0", ZernikeNorm::unit);
  EXPECT_NEAR(modes->front().waves, 2.0 / std::sqrt(6.0), 1e-12);
}

TEST(ModesText, WhatIsNoModeIsNamed) {
  for (const char* text : {";", " ; ", " ", "2;-2", "2,-2", "2,-2:", "2,-2:x", "2,1:0.5",
                           "2,-2:0.5 waves", "2,-2:nan", "2,-2:0.5;4,0:1;2,-2:0.5"}) {
    const auto modes = parse_modes(text, ZernikeNorm::rms);
    ASSERT_FALSE(modes) << text;
    EXPECT_EQ(modes.error().field, "modes");
  }
}

}  // namespace
}  // namespace ovws::cli
