// A registration's file: one of another SLM is read, and not used with a reason that says so.
#include "daemon/ovwsd/sensor/registration_file.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

MeasuredRegistration measured() {
  MeasuredRegistration registration;
  registration.px_per_cycle = {1900.0, 0.0, 0.0, 1900.0};
  registration.base_px = {256.0, 250.0};
  registration.t_taken_ns = 1767225610412345678;
  registration.camera = {{"serial", "A1"}};
  return registration;
}

TEST(RegistrationFile, OfTheConfiguredSlmIsUsed) {
  const RegistrationKind kind{SlmGeometry{}};
  const auto read = kind.read(kind.content(measured()));
  ASSERT_TRUE(read) << read.error().reason;
  EXPECT_EQ(read->px_per_cycle, measured().px_per_cycle);
  EXPECT_EQ(kind.obstacle(*read), "");
  EXPECT_EQ(kind.obstacle(measured()), "");
}

TEST(RegistrationFile, OfAnotherSlmIsNotUsed) {
  SlmGeometry other;
  other.width_px = 1920;
  const RegistrationKind then{other}, now{SlmGeometry{}};
  const auto read = now.read(then.content(measured()));
  ASSERT_TRUE(read) << read.error().reason;
  const std::string why = now.obstacle(*read);
  EXPECT_NE(why.find("1920"), std::string::npos) << why;
  EXPECT_NE(why.find("1280"), std::string::npos) << why;
}

TEST(RegistrationFile, NamesTheSettingsThatHaveChangedSince) {
  Config then;
  then.modulator = Modulator::fixed;
  then.array.pitch_um = 150.0;
  Config now = then;
  const auto of = [](const Config& config) {
    return RegistrationKind{config.slm.geometry, registration_settings(config)};
  };
  const auto changed = [&] {
    const auto read = of(now).read(of(then).content(measured()));
    return read ? of(now).changed_settings(*read) : std::vector<std::string>{read.error().reason};
  };
  EXPECT_TRUE(changed().empty());
  now.array.pitch_um = 152.5;
  now.array.plate.levels = 8;  // used as configured
  EXPECT_EQ(changed(), std::vector<std::string>{"array.pitch_um was 150.0, and is 152.5"});
  now.optics.focal_length_mm = 100.0;
  now.sensor.grid = Grid::square;
  EXPECT_EQ(changed().size(), 3U);
  // Written again, as by array.fit, it remains that of then.
  const auto again = of(now).read(of(now).content(*of(now).read(of(then).content(measured()))));
  ASSERT_TRUE(again);
  EXPECT_EQ(of(now).changed_settings(*again).size(), 3U);
}

TEST(RegistrationFile, OfAnSlmDoesNotDependOnTheArray) {
  Config config;
  const auto before = registration_settings(config);
  config.array.pitch_um = 300.0;
  config.sensor.grid = Grid::square;
  EXPECT_EQ(registration_settings(config), before);
  config.optics.centre_px = Vec2{100.0, 200.0};
  EXPECT_NE(registration_settings(config), before);
}

TEST(RegistrationFile, OfAnEarlierVersionNamesNone) {
  const RegistrationKind kind{SlmGeometry{}, registration_settings(Config{})};
  auto content = kind.content(measured());
  content.erase("settings");
  const auto read = kind.read(content);
  ASSERT_TRUE(read);
  EXPECT_TRUE(kind.changed_settings(*read).empty());
}

}  // namespace
}  // namespace ovws
