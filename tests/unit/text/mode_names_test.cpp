#include "daemon/ovws/text/mode_names.hpp"

#include <gtest/gtest.h>

#include "core/optics/zernike.hpp"

namespace ovws::cli {
namespace {

TEST(ModeNames, EveryNameIsItsMode) {
  ASSERT_EQ(mode_names().size(), 15U);
  for (int j = 0; j < int(mode_names().size()); ++j) {
    EXPECT_EQ(mode_of(mode_names()[std::size_t(j)]).value(), j);
    EXPECT_EQ(mode_of(zernike_name(j)).value(), j);
  }
}

TEST(ModeNames, NumbersAreIndicesOrOrders) {
  EXPECT_EQ(mode_of("7").value(), 7);
  EXPECT_EQ(mode_of("3,-1").value(), 7);
  EXPECT_EQ(mode_of("230").value(), 230);
}

TEST(ModeNames, WordsMayBeLeftOutWhileTheNameIsUnique) {
  EXPECT_EQ(mode_of("spherical").value(), 12);
  EXPECT_EQ(mode_of("Coma_Vertical").value(), 7);
  EXPECT_EQ(mode_of("astigmatism-oblique").value(), 3);
  EXPECT_EQ(mode_of("secondary oblique").value(), 11);
}

TEST(ModeNames, AnAmbiguousNameIsRefusedWithItsCandidates) {
  EXPECT_EQ(mode_of("coma").error().reason,
            "\"coma\" is ambiguous: vertical-coma or horizontal-coma");
  EXPECT_EQ(mode_of("astigmatism").error().reason,
            "\"astigmatism\" is ambiguous: oblique-astigmatism or vertical-astigmatism");
}

TEST(ModeNames, WhatIsNoModeIsRefused) {
  EXPECT_NE(mode_of("comma").error().reason.find("did you mean coma?"), std::string::npos);
  EXPECT_NE(mode_of("defocuss").error().reason.find("did you mean defocus?"), std::string::npos);
  for (const char* text : {"", "-", "231", "-1", "2,1", "1,2,3", "3,", "9999999999", "x"}) {
    const auto mode = mode_of(text);
    ASSERT_FALSE(mode) << text;
    EXPECT_EQ(mode.error().field, "modes");
  }
}

}  // namespace
}  // namespace ovws::cli
