#include "daemon/ovwsd/camera/camera_limits.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

CameraLimits limits() {
  CameraLimits limits;
  limits.gain_db = {0.0, 48.0, 0.1};
  limits.exposure_us = {10.0, 1e6, 1.0};
  limits.frame_rate_hz = {0.1, 1000.0, 0.0};
  limits.roi_width = {16, 1024, 4};
  limits.roi_height = {16, 768, 4};
  limits.sensor_width = 1024;
  limits.sensor_height = 768;
  limits.pixel_formats = {PixelFormat::mono8, PixelFormat::mono12};
  return limits;
}

TEST(CameraLimits, WhatTheDeviceCanDoPassesUnchanged) {
  const CameraSettings wanted;
  const auto checked = within_limits(wanted, limits(), false);
  ASSERT_TRUE(checked);
  EXPECT_EQ(*checked, wanted);
}

TEST(CameraLimits, ARefusalNamesTheFieldAndTheRange) {
  CameraSettings wanted;
  wanted.gain_db = 60.0;
  const auto checked = within_limits(wanted, limits(), false);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, Errc::invalid);
  EXPECT_EQ(checked.error().field, "gain_db");
  EXPECT_EQ(checked.error().max, 48.0);
}

TEST(CameraLimits, AGainIsTakenInTheUnitOfTheCameraOnly) {
  CameraLimits raw = limits();
  raw.gain_raw = {0.0, 10.0, 1.0};
  CameraSettings wanted;
  EXPECT_TRUE(within_limits(wanted, raw, false)) << "0 dB, the default, asks for nothing";
  wanted.gain_db = 3.0;
  EXPECT_EQ(within_limits(wanted, raw, false).error().field, "gain_db");
  EXPECT_EQ(within_limits(wanted, raw, true).error().field, "gain_db") << "cannot be clamped";
  wanted.gain_db = kUnknownGain;
  wanted.gain_raw = 11.0;
  EXPECT_EQ(within_limits(wanted, raw, false).error().field, "gain_raw");
  EXPECT_EQ(within_limits(wanted, raw, true)->gain_raw, 10.0);
  wanted.gain_raw = 5.0;
  EXPECT_EQ(within_limits(wanted, raw, false), wanted);
  const auto other = within_limits(wanted, limits(), false);  // of a camera with a gain in dB
  EXPECT_EQ(other.error().field, "gain_raw");
}

TEST(CameraLimits, ClampBringsNumbersIntoRange) {
  CameraSettings wanted;
  wanted.gain_db = -3.0;
  wanted.exposure_us = 1e9;
  wanted.roi = {900, 700, 512, 512};
  const auto checked = within_limits(wanted, limits(), true);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->gain_db, 0.0);
  EXPECT_EQ(checked->exposure_us, 1e6);
  EXPECT_EQ(checked->roi, (Roi{512, 256, 512, 512}));
}

TEST(CameraLimits, ClampEndsPackedRowsAtAWholeByte) {
  CameraLimits packed = limits();
  packed.pixel_formats = {PixelFormat::mono10p};
  CameraSettings wanted;
  wanted.pixel_format = PixelFormat::mono10p;
  wanted.roi.width = 510;
  EXPECT_EQ(within_limits(wanted, packed, true)->roi.width, 508);
  EXPECT_EQ(within_limits(wanted, packed, false)->roi.width, 510);  // left to the camera to refuse
}

TEST(CameraLimits, ARegionMustLieOnTheSensor) {
  CameraSettings wanted;
  wanted.roi = {513, 0, 512, 512};
  EXPECT_EQ(within_limits(wanted, limits(), false).error().field, "roi.x");
  wanted.roi = {0, 257, 512, 512};
  EXPECT_EQ(within_limits(wanted, limits(), false).error().field, "roi.y");
  wanted.roi = {0, 0, 2000, 512};
  EXPECT_EQ(within_limits(wanted, limits(), false).error().field, "roi.width");
}

TEST(CameraLimits, AFormatThatTheCameraHasNotIsRefusedEvenWithClamp) {
  CameraSettings wanted;
  wanted.pixel_format = PixelFormat::mono16;
  const auto checked = within_limits(wanted, limits(), true);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().field, "pixel_format");
  EXPECT_NE(checked.error().reason.find("Mono12"), std::string::npos);
}

}  // namespace
}  // namespace ovws
