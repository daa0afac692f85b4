/// Camera probes that need no control of the camera, and queries of the network path to it.
#include <gtest/gtest.h>

#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/aravis/camera_link.hpp"
#include "drivers/aravis/gige_probe.hpp"
#include "drivers/aravis/listing.hpp"
#include "tests/contract/camera/fake_camera.hpp"

namespace ovws::testing {
namespace {

TEST(AravisCamera, ProbingReportsWhetherAnotherProgramControlsItAndTakesNoControl) {
  const auto device = start_fake_camera(OVWS_SFNC_CAMERA_XML);
  for (int i = 0; i < 2; ++i) {
    const auto before = ask_gige_camera(kFakeCameraAddress);
    ASSERT_TRUE(before) << before.error().reason;
    EXPECT_EQ(before->vendor, "Aravis");
    EXPECT_EQ(before->serial, "OVWS7");
    EXPECT_FALSE(before->controlled);
  }
  AravisConfig config;
  config.id = kFakeCameraAddress;
  config.packet_size_bytes = 1400;
  auto camera = open_aravis_camera(config);
  ASSERT_TRUE(camera) << camera.error().reason;
  ASSERT_TRUE((*camera)->start());
  const auto meanwhile = ask_gige_camera(kFakeCameraAddress);
  ASSERT_TRUE(meanwhile);
  EXPECT_TRUE(meanwhile->controlled);
  EXPECT_EQ(meanwhile->packet_size_bytes, 1400);
  list_cameras();
  EXPECT_TRUE((*camera)->alive());
  GrabbedFrame frame;
  ASSERT_EQ((*camera)->grab(frame, std::chrono::seconds(5)), GrabStatus::frame);
  (*camera)->release(frame.slot);
  camera->reset();
  EXPECT_FALSE(ask_gige_camera(kFakeCameraAddress)->controlled);
}

TEST(AravisCamera, ProbingWhereNoCameraIsSaysSo) {
  const auto silent = ask_gige_camera("127.0.0.1");
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code, Errc::unavailable);
  const auto wrong = ask_gige_camera("OVWS7");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Errc::invalid);
}

TEST(AravisCamera, IsListedWithItsAddressAndFoundByIdAndSerialNumber) {
  EXPECT_TRUE(list_cameras().empty());
  const auto device = start_fake_camera(OVWS_SFNC_CAMERA_XML);
  const auto cameras = list_cameras();
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(names_of(cameras), "Aravis-Fake-OVWS7 at 127.0.0.1");
  EXPECT_TRUE(cameras[0].gige);
  EXPECT_EQ(find_listed(cameras, "OVWS7"), &cameras[0]);
  EXPECT_EQ(find_listed(cameras, "Aravis-Fake-OVWS7"), &cameras[0]);
  EXPECT_EQ(find_listed(cameras, "OVWS8"), nullptr);
  EXPECT_EQ(find_listed(cameras, ""), nullptr);
}

TEST(AravisCamera, TheWayToItIsAnInterfaceOfThisMachine) {
  const auto path = path_to(kFakeCameraAddress);
  ASSERT_TRUE(path) << path.error().reason;
  EXPECT_EQ(path->interface, "lo");
  EXPECT_EQ(path->own_address, kFakeCameraAddress);
  EXPECT_TRUE(path->same_network);
  EXPECT_GE(path->mtu_bytes, 576);
  EXPECT_FALSE(path->link_mbps);
  const auto none = path_to("192.0.2.7");  // the namespace has the loopback interface only
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::unavailable);
  EXPECT_EQ(path_to("OVWS7").error().code, Errc::invalid);
  EXPECT_FALSE(usb_link_mbps("no such device"));
}

}  // namespace
}  // namespace ovws::testing
