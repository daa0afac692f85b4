// A registration's file: one of another SLM is read, and not used with a reason that says so.
#include "daemon/ovwsd/library/measured_registration.hpp"

#include <gtest/gtest.h>

#include "proto/tables/optics.hpp"

namespace ovws {
namespace {

MeasuredRegistration measured() {
  MeasuredRegistration registration;
  registration.px_per_cycle = {1900.0, 0.0, 0.0, 1900.0};
  registration.base_px = {256.0, 250.0};
  registration.t_taken_ns = 1767225610412345678;
  registration.key.camera = {{"serial", "A1"}};
  registration.key.slm = to_json(SlmGeometry{});
  return registration;
}

TEST(RegistrationFile, OfTheConfiguredSlmIsUsedAndOfAnotherItIsNot) {
  const auto read = registration_from(registration_content(measured()));
  ASSERT_TRUE(read) << read.error().reason;
  EXPECT_EQ(read->px_per_cycle, measured().px_per_cycle);
  BenchKey now = measured().key;
  EXPECT_EQ(differing(respect::kRegistration, read->key, now), 0U);
  SlmGeometry other;
  other.width_px = 1920;
  now.slm = to_json(other);
  const auto differ = differing(respect::kRegistration, read->key, now);
  EXPECT_EQ(words_of(differ, read->key, now), "slm.width was 1280, and is 1920");
}

TEST(RegistrationFile, NamesTheSettingsThatHaveChangedSince) {
  Config then;
  then.modulator = Modulator::fixed;
  then.array.pitch_um = 150.0;
  const auto use = [](const Config& config, BenchKey& key) {
    key.optics = to_json(config.optics);
    key.array = array_json(config);
  };
  MeasuredRegistration registration = measured();
  use(then, registration.key);
  Config config = then;
  const auto changed = [&] {
    const auto read = registration_from(registration_content(registration));
    if (!read) return read.error().reason;
    BenchKey now;
    use(config, now);
    const auto differ = differing(respect::kRegistrationSettings, read->key, now);
    return words_of(differ, read->key, now);
  };
  EXPECT_EQ(changed(), "");
  config.array.pitch_um = 152.5;
  config.array.plate.levels = 8;  // used as configured
  EXPECT_EQ(changed(), "array.pitch_um was 150.0, and is 152.5");
  config.optics.focal_length_mm = 100.0;
  config.sensor.grid = Grid::square;
  EXPECT_EQ(changed(),
            "optics.focal_length_mm was 200.0, and is 100.0; array.grid was \"hexagonal\", and is "
            "\"square\"; array.pitch_um was 150.0, and is 152.5");
}

TEST(RegistrationFile, OfAnSlmDoesNotDependOnTheArray) {
  Config config;
  EXPECT_TRUE(array_json(config).is_null());
  config.modulator = Modulator::fixed;
  EXPECT_FALSE(array_json(config).is_null());
}

}  // namespace
}  // namespace ovws
