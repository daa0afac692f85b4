#include "daemon/examine/machine/machine.hpp"

#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {
namespace {

/// A GigE camera on a good gigabit interface, free.
CameraFacts gige() {
  CameraFacts facts;
  facts.config.id = "192.168.7.20";
  facts.camera = ListedCamera{"Maker-M1-77", "77", "192.168.7.20", true};
  facts.answer = GigeAnswer{"Maker", "M1", "77", false, 1000, 9000};
  facts.path = NetworkPath{"eth1", "192.168.7.1", 9000, 1000, true};
  facts.usbfs_mb = 16;
  facts.rmem_max_bytes = 4 << 20;
  return facts;
}

CameraFacts usb() {
  CameraFacts facts;
  facts.config.id = "77";
  facts.camera = ListedCamera{"Maker-M1-77", "77", "", false};
  facts.usb_mbps = 5000;
  facts.usbfs_mb = 16;
  facts.rmem_max_bytes = 4 << 20;
  return facts;
}

CameraFacts nothing_found(const std::string& id) {
  CameraFacts facts;
  facts.config.id = id;
  return facts;
}

TEST(DoctorCamera, AHealthyGigeOrUsbCameraHasNoFinding) {
  for (const auto& facts : {gige(), usb()}) {
    for (const Finding& one : answers(facts)) {
      EXPECT_TRUE(one.severity == Severity::good || one.severity == Severity::not_here) << one.text;
    }
  }
}

TEST(DoctorCamera, IsFoundOrNot) {
  expect(gige(), "camera.found", Severity::good);
  expect(usb(), "camera.found", Severity::good);
  expect(nothing_found("77"), "camera.found", Severity::bad, "arv-tool-0.8");
  auto other = nothing_found("78");
  other.listed = {{"Maker-M1-77", "77", "192.168.7.20", true}};
  expect(other, "camera.found", Severity::bad, "\"camera\": {\"id\": \"192.168.7.20\"}");
  other.listed = {{"Maker-M1-77", "77", "", false}};
  expect(other, "camera.found", Severity::bad, "\"id\": \"Maker-M1-77\"");
  auto deaf = gige();
  deaf.answer.reset();
  expect(deaf, "camera.found", Severity::bad, "ip address add 192.168.7.1/24");
}

TEST(DoctorCamera, AnotherProgramThatControlsItIsReported) {
  expect(gige(), "camera.control", Severity::good);
  auto taken = gige();
  taken.answer->controlled = true;
  expect(taken, "camera.control", Severity::warning);
  taken.daemon = DaemonsCamera::with;
  expect(taken, "camera.control", Severity::good);
  taken.daemon = DaemonsCamera::without;
  expect(taken, "camera.control", Severity::bad);
  expect(usb(), "camera.control", Severity::not_here);
  expect(nothing_found("77"), "camera.control", Severity::not_here);
}

TEST(DoctorCamera, IsReachedByAnInterfaceInItsNetwork) {
  expect(gige(), "camera.interface", Severity::good);
  auto routed = gige();
  routed.path->same_network = false;
  expect(routed, "camera.interface", Severity::warning, "192.168.7.1/24");
  expect(nothing_found("192.168.7.1"), "camera.interface", Severity::bad, "192.168.7.2/24");
  expect(nothing_found("77-serial"), "camera.interface", Severity::not_here);
  expect(usb(), "camera.interface", Severity::not_here);
}

TEST(DoctorCamera, ItsLinkCarriesTheConfiguredFrames) {
  auto slow = gige();  // 512 x 512 bytes, 100 a second, with headers: 221 Mbit/s
  expect(slow, "camera.link", Severity::good);
  slow.answer->link_mbps = 222;
  expect(slow, "camera.link", Severity::good);
  slow.answer->link_mbps = 100;
  expect(slow, "camera.link", Severity::bad, "\"frame_rate_hz\": 45}");
  slow = gige();
  slow.path->link_mbps = 10;
  expect(slow, "camera.link", Severity::bad, "\"frame_rate_hz\": 4}");
  slow.path->link_mbps = slow.answer->link_mbps = std::nullopt;
  expect(slow, "camera.link", Severity::not_here);
  auto old_port = usb();
  old_port.usb_mbps = 480;
  expect(old_port, "camera.link", Severity::good);
  old_port.usb_mbps = 12;
  expect(old_port, "camera.link", Severity::bad);
}

TEST(DoctorCamera, PacketsLargerThanTheInterfacesMtuAreReported) {
  auto facts = gige();
  expect(facts, "camera.packets", Severity::good);
  facts.path->mtu_bytes = 1500;
  expect(facts, "camera.packets", Severity::warning, "ip link set dev eth1 mtu 9000");
  facts.answer->controlled = true;  // now it reports what it sends
  expect(facts, "camera.packets", Severity::bad);
  facts.answer->packet_size_bytes = 1500;
  expect(facts, "camera.packets", Severity::warning);
  facts.config.packet_size_bytes = 1500;
  expect(facts, "camera.packets", Severity::good);
  facts.path.reset();
  expect(facts, "camera.packets", Severity::not_here);
  expect(usb(), "camera.packets", Severity::not_here);
}

TEST(DoctorCamera, TheKernelGivesItsSocketRoom) {
  auto facts = gige();
  expect(facts, "camera.socket_buffer", Severity::good);
  facts.rmem_max_bytes = 212992;
  expect(facts, "camera.socket_buffer", Severity::warning, "sysctl -w net.core.rmem_max=4194304");
  facts.rmem_max_bytes.reset();
  expect(facts, "camera.socket_buffer", Severity::not_here);
  expect(usb(), "camera.socket_buffer", Severity::not_here);
}

TEST(DoctorCamera, TheKernelGivesUsbRoom) {
  auto facts = usb();  // 32 frames of 256 KiB, and one MiB
  facts.usbfs_mb = 9;
  expect(facts, "camera.usb_memory", Severity::good);
  facts.usbfs_mb = 8;
  expect(facts, "camera.usb_memory", Severity::bad, "echo 1000 | sudo tee /sys/module/usbcore/");
  facts.usbfs_mb = 0;  // no limit
  expect(facts, "camera.usb_memory", Severity::good);
  facts.usbfs_mb.reset();
  expect(facts, "camera.usb_memory", Severity::not_here);
  expect(gige(), "camera.usb_memory", Severity::not_here);
}

}  // namespace
}  // namespace ovws::examine
