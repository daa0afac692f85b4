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

}  // namespace
}  // namespace ovws
