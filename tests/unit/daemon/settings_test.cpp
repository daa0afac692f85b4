#include "daemon/ovwsd/settings/settings.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

using Keys = std::vector<std::string>;

TEST(ConfigDifference, OfTheSameConfigurationIsNone) {
  const auto keys = difference(Config{}, Config{});
  EXPECT_EQ(keys.live, Keys{});
  EXPECT_EQ(keys.restart, Keys{});
}

TEST(ConfigDifference, NamesWhatChangesLiveAndWhatWaits) {
  Config after;
  after.camera.settings.exposure_us += 1.0;
  after.camera.settings.roi.width -= 16;
  after.camera.transfer_ms += 1.0;
  after.tracking.tracker = TrackerKind::weighted;
  after.refine.rate_hz *= 0.5;
  after.stream.image_rate_hz *= 0.5;
  after.slm.settle_ms += 1.0;
  after.slm.geometry.pitch_um += 1.0;
  after.camera.id = "1234";
  const auto keys = difference(Config{}, after);
  EXPECT_EQ(keys.live,
            (Keys{"camera.exposure_us", "camera.id", "camera.roi.width", "refine.rate_hz",
                  "slm.settle_ms", "stream.image_rate_hz", "tracking.tracker"}));
  EXPECT_EQ(keys.restart, (Keys{"camera.transfer_ms", "slm.pitch_um"}));
}

TEST(ConfigDifference, OneKeyOfALiveRoomWaits) {
  Config after;
  after.tracking.kernel_radius += 1;
  EXPECT_EQ(difference(Config{}, after).restart, Keys{"tracking.kernel_radius"});
  EXPECT_EQ(difference(Config{}, after).live, Keys{});
}

TEST(ConfigDifference, TheSensorOfAFixedArrayWaits) {
  Config fixed;
  fixed.modulator = Modulator::fixed;
  Config after = fixed;
  after.sensor.charge += 1;
  after.tracking.tracker = TrackerKind::weighted;
  EXPECT_EQ(difference(fixed, after).restart, Keys{"sensor.charge"});
  EXPECT_EQ(difference(fixed, after).live, Keys{"tracking.tracker"});
}

TEST(ConfigDifference, NamesAValueThatBecameNullAndOneThatWasNull) {
  Config with;
  with.refine.electrons_per_dn = 2.0;
  EXPECT_EQ(difference(Config{}, with).live, Keys{"refine.electrons_per_dn"});
  EXPECT_EQ(difference(with, Config{}).live, Keys{"refine.electrons_per_dn"});
}

TEST(AsAsked, IsTheValueThatTheCameraMadeItOf) {
  CameraSnapshot now;
  now.asked.exposure_us = 1000.0;
  now.settings.exposure_us = 999.98;
  now.asked.roi.x = 17;
  now.settings.roi.x = 16;
  CameraSettings same = now.settings;
  EXPECT_EQ(as_requested(same, now), now.asked);
  EXPECT_EQ(as_requested(now.asked, now), now.asked);
  CameraSettings other = now.settings;
  other.exposure_us = 999.9;
  EXPECT_EQ(as_requested(other, now).exposure_us, 999.9);
  EXPECT_EQ(as_requested(other, now).roi.x, 17);
}

TEST(CameraChange, HoldsWhatDiffersAndMakesTheOneOfTheOther) {
  CameraSettings after;
  EXPECT_EQ(CameraSet::difference(CameraSettings{}, after).applied_to({}), CameraSettings{});
  after.gain_db = 3.0;
  after.pixel_format = PixelFormat::mono12;
  after.roi = {16, 32, 128, 64};
  const CameraSet change = CameraSet::difference(CameraSettings{}, after);
  EXPECT_EQ(change.applied_to({}), after);
  EXPECT_FALSE(change.gives(&CameraSettings::exposure_us));
  EXPECT_FALSE(change.gives(&CameraSettings::frame_rate_hz));
}

TEST(CameraChange, OfAGainNamesTheOneThatIsStated) {
  CameraSettings in_db, raw;
  in_db.gain_db = 3.0;
  raw.gain_db = kUnknownGain;
  raw.gain_raw = 7.0;
  const auto gives = [](const CameraSet& change) {
    return std::pair(change.gives(&CameraSettings::gain_db),
                     change.gives(&CameraSettings::gain_raw));
  };
  EXPECT_EQ(gives(CameraSet::difference(in_db, raw)), std::pair(false, true));
  EXPECT_EQ(gives(CameraSet::difference(raw, in_db)), std::pair(true, false));
  EXPECT_EQ(gives(CameraSet::difference(raw, raw)), std::pair(false, false));
  EXPECT_EQ(CameraSet::difference(in_db, raw).applied_to(in_db), raw);
  EXPECT_EQ(CameraSet::difference(raw, in_db).applied_to(raw), in_db);
}

}  // namespace
}  // namespace ovws
