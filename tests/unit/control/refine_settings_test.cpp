/// The live refinement's settings: what is refused, and how they follow the camera's pixel format.
#include "core/control/refine_settings.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

std::string fault_of(const RefineSetup& settings) {
  const auto checked = check_refine(settings);
  return checked ? std::string() : checked.error().field;
}

TEST(RefineSetup, TheDefaultIsWholeAndOff) {
  EXPECT_FALSE(RefineSetup{}.enabled);
  EXPECT_EQ(fault_of({}), "");
}

TEST(RefineSetup, WhatOnlyTogetherIsWrongIsRefused) {
  RefineSetup settings;
  settings.enabled = true;
  EXPECT_EQ(fault_of(settings), "electrons_per_dn");
  settings.electrons_per_dn = 2.0;
  EXPECT_EQ(fault_of(settings), "");
  settings.saturation_dn = 300.0;
  EXPECT_EQ(fault_of(settings), "saturation_dn");
  settings.saturation_dn = 200.0;
  settings.black_level_dn = 200.0;
  EXPECT_EQ(fault_of(settings), "black_level_dn");
  settings.format = PixelFormat::mono12;
  settings.saturation_dn.reset();
  EXPECT_EQ(fault_of(settings), "");
}

TEST(RefineSetup, FollowTheFormatThereAndBack) {
  RefineSetup settings;
  settings.electrons_per_dn = 40.0;
  settings.black_level_dn = 2.0;
  settings.saturation_dn = 250.0;
  const RefineSetup deep = in_format(settings, PixelFormat::mono12);
  EXPECT_EQ(deep.electrons_per_dn, 2.5);
  EXPECT_EQ(deep.black_level_dn, 32.0);
  EXPECT_EQ(deep.saturation_dn, 4000.0);
  EXPECT_EQ(deep.read_noise_e, settings.read_noise_e);
  EXPECT_EQ(in_format(deep, PixelFormat::mono8), settings);
}

TEST(RefineSetup, StayWholeInEveryFormat) {
  RefineSetup settings;
  settings.format = PixelFormat::mono12;
  settings.saturation_dn = 4095.0;
  EXPECT_EQ(in_format(settings, PixelFormat::mono8).saturation_dn, 255.0);
  EXPECT_EQ(fault_of(in_format(settings, PixelFormat::mono8)), "");
  settings.saturation_dn = 4.0;
  EXPECT_EQ(in_format(settings, PixelFormat::mono8).saturation_dn, 1.0);
}

TEST(RefineSetup, TheCameraIsTheSameWhateverTheRate) {
  RefineSetup a, b;
  a.rate_hz = 7.0;
  a.enabled = true;
  EXPECT_TRUE(same_fit(a, b));
  b.read_noise_e = 6.0;
  EXPECT_FALSE(same_fit(a, b));
}

}  // namespace
}  // namespace ovws
