#include "config/devices.hpp"

#include <gtest/gtest.h>

#include <set>

namespace ovws {
namespace {

TEST(Devices, EachModelHasANameOfItsOwnASizeAndASource) {
  const Devices& known = known_devices();
  EXPECT_GE(known.slms.size(), 5U);
  EXPECT_GE(known.cameras.size(), 8U);
  std::set<std::string> names;
  for (const SlmModel& slm : known.slms) {
    EXPECT_TRUE(names.insert(slm.name).second) << slm.name;
    EXPECT_FALSE(slm.source.empty()) << slm.name;
    EXPECT_GT(slm.settle_ms, 0.0) << slm.name;
    EXPECT_GE(slm.geometry.width_px, slm.geometry.height_px) << slm.name;
  }
  for (const CameraModel& camera : known.cameras) {
    EXPECT_TRUE(names.insert(camera.name).second) << camera.name;
    EXPECT_FALSE(camera.source.empty()) << camera.name;
    EXPECT_GT(camera.pitch_um, 1.0) << camera.name;
  }
}

}  // namespace
}  // namespace ovws
