#include "daemon/examine/machine/machine.hpp"

#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {
namespace {

sdl::Output output(const std::string& name, int x, int width, int height) {
  sdl::Output out;
  out.name = name;
  out.connected = true;
  out.x = x;
  out.width = out.mode_width = width;
  out.height = out.mode_height = height;
  return out;
}

/// A desktop and an SLM of 1280x768 beside it.
DisplayFacts bench() {
  sdl::DisplayProbe probe;
  probe.outputs = {output("DP-1", 0, 1920, 1080), output("HDMI-1", 1920, 1280, 768)};
  probe.outputs[0].primary = true;
  probe.colour_depth_bits = 24;
  return {{"HDMI-1", 1280, 768, false}, probe, true};
}

sdl::Output& slm(DisplayFacts& facts) {
  return facts.probe->outputs[1];
}

TEST(DoctorDisplay, AGoodBenchIsAllRight) {
  for (const Finding& one : answers(bench())) EXPECT_EQ(one.severity, Severity::good) << one.text;
}

TEST(DoctorDisplay, AnUnresponsiveServerIsAFaultAndWaylandIsNotJudged) {
  auto facts = bench();
  facts.probe = fail(Errc::unavailable, "slm.display", "does not answer");
  expect(facts, "slm.server", Severity::bad, "restart display-manager");
  expect(facts, "slm.mode", Severity::not_here);
  facts.daemon_shows = true;
  expect(facts, "slm.server", Severity::not_here, "DISPLAY and XAUTHORITY of the daemon");
  facts.daemon_shows = false;
  facts.server_named = false;
  expect(facts, "slm.server", Severity::bad, "export DISPLAY=:0");
  facts.probe = fail(Errc::refused, "slm.display", "the display system is wayland");
  expect(facts, "slm.server", Severity::not_here);
}

TEST(DoctorDisplay, GreyLevelsNeed24Bits) {
  auto facts = bench();
  facts.probe->colour_depth_bits = 30;
  expect(facts, "slm.server", Severity::bad, "DefaultDepth 24");
}

TEST(DoctorDisplay, TheOutputIsThereAndNotTheDesktop) {
  auto facts = bench();
  facts.config.output = "HDMI-2";
  expect(facts, "slm.output", Severity::bad, "\"slm\": {\"display\": \"HDMI-1\"}");
  expect(facts, "slm.mode", Severity::not_here);
  facts.config = {"DP-1", 1920, 1080, false};
  expect(facts, "slm.output", Severity::bad, "\"display\": \"HDMI-1\"");
  facts.config.allow_primary = true;
  expect(facts, "slm.output", Severity::good);
  facts = bench();
  slm(facts).x = 100;  // over the desktop
  expect(facts, "slm.output", Severity::bad, "xrandr --output HDMI-1 --right-of DP-1");
  facts.probe->outputs.erase(facts.probe->outputs.begin());
  expect(facts, "slm.output", Severity::bad, "\"allow_primary\": true");
}

TEST(DoctorDisplay, AModeThatDiffersFromTheSlmsSizeIsAFault) {
  auto facts = bench();
  slm(facts).mode_width = slm(facts).width = 1024;
  expect(facts, "slm.mode", Severity::bad, "xrandr --output HDMI-1 --mode 1280x768");
  expect(facts, "slm.output", Severity::good);
  facts = bench();
  slm(facts).width = 2560;
  expect(facts, "slm.mode", Severity::bad, "--scale 1x1");
  facts = bench();
  slm(facts).upright = false;
  expect(facts, "slm.mode", Severity::bad, "--rotate normal");
  facts = bench();
  slm(facts).width = slm(facts).height = 0;
  expect(facts, "slm.mode", Severity::bad, "--mode 1280x768 --right-of DP-1");
  expect(facts, "slm.gamma", Severity::not_here);
  slm(facts).connected = false;
  expect(facts, "slm.mode", Severity::bad);
}

TEST(DoctorDisplay, GammaPowerSavingAndScreenSaverAreReported) {
  auto facts = bench();
  slm(facts).linear_gamma = false;
  expect(facts, "slm.gamma", Severity::bad, "xrandr --output HDMI-1 --gamma 1:1:1");
  facts.probe->power_saving = true;
  expect(facts, "slm.power", Severity::warning, "xset -dpms");
  facts.probe->asleep = true;
  expect(facts, "slm.power", Severity::bad, "xset dpms force on");
  facts.probe->screen_saver_s = 600;
  expect(facts, "slm.screen_saver", Severity::warning, "xset s off");
  facts.probe->composited = true;
  expect(facts, "slm.compositor", Severity::warning, "slm.settle");
}

}  // namespace
}  // namespace ovws::examine
