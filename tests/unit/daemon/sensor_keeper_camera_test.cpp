/// SensorKeeper: measurements of another image or camera, with the fake display of
/// keeper_bench.hpp.
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

#include <gtest/gtest.h>

#include "tests/unit/daemon/keeper_bench.hpp"

namespace ovws {
namespace {

using test::Keeper, test::kFirst, test::kSecond;

TEST_F(Keeper, WhatWasMeasuredOfAnotherImageIsRefused) {
  const std::uint64_t epoch = keeper_->snapshot()->sensor_epoch;
  turn_to(Holder::job);
  CameraSettings camera = config_.camera.settings;
  camera.roi = {16, 0, 640, 816};
  keeper_->camera_changed(camera, std::nullopt);
  work();
  const auto spots = std::make_shared<std::vector<ReferenceSpots>>();
  const auto refused = edit(use_reference(epoch, {}, spots));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera");
  EXPECT_FALSE(keeper_->snapshot()->reference);
}

TEST_F(Keeper, ARegistrationOfAnotherCameraIsNotUsed) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  ASSERT_TRUE(keeper_->snapshot()->registration);
  keeper_->camera_changed(config_.camera.settings, kSecond);
  work();
  EXPECT_FALSE(keeper_->snapshot()->registration);
}

/// The registration says that spots are large enough for the tracker, the configuration that they
/// are not: without the registration no plan can be built.
TEST_F(Keeper, ACameraForWhichNoPlanCanBeBuiltIsReportedAndNothingMeasuredWithAnotherIsUsed) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  end();
  config_.optics.focal_length_mm = 10.0;
  start();
  keeper_->camera_changed(config_.camera.settings, kFirst);
  work();
  ASSERT_TRUE(keeper_->snapshot()->registration);
  const SensorView before = keeper_->snapshot();
  (void)errors();
  CameraSettings other_region = config_.camera.settings;
  other_region.roi = {16, 0, 640, 816};
  keeper_->camera_changed(other_region, kSecond);
  work();
  const SensorView now = keeper_->snapshot();
  EXPECT_FALSE(now->registration);
  EXPECT_FALSE(now->optics.registered);
  EXPECT_EQ(now->plan_id, 0U);
  EXPECT_GT(now->sensor_epoch, before->sensor_epoch) << "frames of the previous plan do not count";
  const auto found = errors();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].starts_with("the camera's image cannot be measured: lambda/d")) << found[0];
  EXPECT_EQ(now->obstacle.reason, found[0]);
  EXPECT_NE(now->obstacle.action.find("camera.set"), std::string::npos) << now->obstacle.action;
  EXPECT_GT(now->obstacle.t_since_ns, 0);
}

/// Without the registration the spots are too small for a colour camera only.
TEST_F(Keeper, AnotherCameraIsJudgedByItsOwnImageAlone) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  end();
  config_.optics.focal_length_mm = 16.0;  // lambda/d of 4.8 px
  start();
  CameraSettings colour = config_.camera.settings;
  colour.pixel_format = PixelFormat::bayer_rg8;
  keeper_->camera_changed(colour, kFirst);
  work();
  ASSERT_TRUE(keeper_->snapshot()->registration);
  ASSERT_GT(keeper_->snapshot()->plan_id, 0U);
  (void)errors();
  CameraSettings mono = config_.camera.settings;
  mono.roi = {16, 0, 640, 816};
  keeper_->camera_changed(mono, kSecond);
  work();
  EXPECT_FALSE(keeper_->snapshot()->registration);
  EXPECT_GT(keeper_->snapshot()->plan_id, 0U);
  EXPECT_EQ(errors(), std::vector<std::string>{});
}

TEST_F(Keeper, WhatAJobHadChangedIsRestoredEvenIfTheCamerasImageCannotBeMeasuredAnyMore) {
  use_map(160.0);  // lambda/d of 5 px: too small for a colour camera
  ASSERT_TRUE(edit(set_aberration({{4, 0.1}}))) << "which the display shows now";
  const Image<std::uint8_t> user = screen_.picture();
  turn_to(Holder::job);
  const Painter white = [](const HologramRenderer&, Image<std::uint8_t>& grey) {
    grey = Image<std::uint8_t>(160, 96);
    std::fill(grey.pixels.begin(), grey.pixels.end(), std::uint8_t(255));
  };
  ASSERT_TRUE(edit(show_request({{}, white})));
  ASSERT_NE(screen_.picture().pixels, user.pixels);
  CameraSettings colour = config_.camera.settings;
  colour.pixel_format = PixelFormat::bayer_rg8;
  keeper_->camera_changed(colour, std::nullopt);
  work();
  EXPECT_EQ(errors().size(), 1U);
  const std::int64_t t_since_ns = keeper_->snapshot()->obstacle.t_since_ns;
  turn_to(Holder::nobody);
  EXPECT_EQ(errors().size(), 1U);
  EXPECT_EQ(keeper_->snapshot()->plan_id, 0U);
  EXPECT_EQ(keeper_->snapshot()->obstacle.t_since_ns, t_since_ns) << "it goes on";
  EXPECT_EQ(screen_.picture().pixels, user.pixels);
  keeper_->camera_changed(config_.camera.settings, std::nullopt);
  work();
  EXPECT_GT(keeper_->snapshot()->plan_id, 0U) << "as soon as a plan can be built";
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "");
}

TEST_F(Keeper, AStartWithAnotherLensThanTheRegistrationsSaysSo) {
  use_map(900.0);
  const auto warned = [this] {
    return !events_where([](const EventMessage& event) {
              return event.kind == "registration" &&
                     event.text.find("optics.focal_length_mm was") != std::string::npos &&
                     event.text.find("registration.run") != std::string::npos;
            }).empty();
  };
  end();
  start();
  EXPECT_FALSE(warned());
  end();
  config_.optics.focal_length_mm *= 1.5;
  start();
  EXPECT_TRUE(keeper_->snapshot()->registration);
  EXPECT_TRUE(warned());
}

}  // namespace
}  // namespace ovws
