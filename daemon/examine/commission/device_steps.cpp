/// Steps that find the devices: this machine, the camera, the SLM's output.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/examine/commission/drawing.hpp"
#include "daemon/examine/commission/light.hpp"
#include "daemon/examine/commission/step.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;

constexpr double kPartOfPeriod = 0.9;  ///< of the time between two frames, for an exposure

void add(std::string& all, const std::string& more, const char* between) {
  all += (all.empty() ? "" : between) + more;
}

// Doctor ------------------------------------------------------------------------------------------

Outcome run_doctor(Bench& bench, Memory&) {
  bench.say("checking this machine");
  examine::Findings findings;
  if (bench.settings().examine) findings = bench.settings().examine();
  const auto status = bench.try_call("system.status");
  if (!status) {
    auto outcome = failed(status.error(), "Start the daemon.");
    outcome.commands = {"sudo systemctl start ovwsd"};
    return outcome;
  }
  Outcome outcome;
  Severity worst = Severity::good;
  std::string faults, fixes;
  for (const examine::Finding& one : findings) {
    if (one.severity < Severity::warning) continue;
    const bool is_later = is_for_later(one);
    worst = std::max(worst, is_later ? Severity::warning : one.severity);
    add(faults, one.name + ": " + one.text, "\n");
    add(fixes, one.name + ": " + (is_later ? "a later step offers the repair" : one.fix), "\n");
    if (!is_later && examine::is_command(one.fix)) outcome.commands.push_back(one.fix);
  }
  outcome.passed = worst != Severity::bad;
  const std::string state = "The daemon is " + text_at(*status, "/state") + ".";
  const auto good = std::ranges::count(findings, Severity::good, &examine::Finding::severity);
  outcome.verdict = advised(
      worst, state + (faults.empty() ? fmt::format(" {} checks are good.", good) : "\n" + faults),
      fixes);
  return outcome;
}

// Camera ------------------------------------------------------------------------------------------

/// Ways to use another camera than that of `serial`, of those that were not tried.
std::vector<Offer> other_cameras(const json& listed, const std::string& serial,
                                 const Memory& memory) {
  std::vector<Offer> offers;
  for (const json& camera : listed.at("cameras")) {
    const std::string id = camera.at("id").get<std::string>();
    if (text_at(camera, "/serial") == serial || memory.tried.contains("use-" + id)) continue;
    const std::string address = text_at(camera, "/address");
    offers.push_back({"use-" + id,
                      "use camera " + id + (address.empty() ? "" : " at " + address),
                      {{"camera.select", {{"id", id}}}}});
  }
  return offers;
}

/// The camera is there, but cannot be used with its settings.
Outcome refused_settings(const std::string& fault, const json& settings, const Memory& memory) {
  auto outcome = failed(fault);
  const double period_us = 1e6 / settings.at("frame_rate_hz").get<double>();
  if (settings.at("exposure_us").get<double>() > period_us && !memory.tried.contains("shorten")) {
    const double exposure_us = std::floor(kPartOfPeriod * period_us);
    outcome.offers = {{"shorten",
                       fmt::format("shorten the exposure to {:.0f} us", exposure_us),
                       {{"camera.set", {{"exposure_us", exposure_us}}}}}};
  }
  return outcome;
}

Outcome run_camera(Bench& bench, Memory& memory) {
  bench.say("listing the cameras");
  const json config = bench.call("config.get");
  const json listed = bench.call("camera.list");
  const json camera = bench.call("camera.get");
  const std::string id = text_at(config, "/camera/id");
  if (!memory.undo) {
    memory.undo = {{}, {{"camera.select", {{"id", id}}}}, "Camera " + id + " is in use again."};
  }
  const json& info = camera.at("info");
  const bool is_connected = camera.at("connected").get<bool>();
  auto offers = other_cameras(listed, is_connected ? text_at(info, "/serial") : "", memory);
  if (!is_connected) {
    const json status = bench.call("system.status");
    const std::string fault = text_at(status, "/camera/fault");
    if (!fault.empty() && text_at(status, "/state") == "fault") {
      return refused_settings(fault, camera.at("settings"), memory);
    }
    const bool is_alone = offers.empty();
    return failed({Errc::unavailable, "camera.id",
                   id + " does not answer" + (is_alone ? ", and no camera was found" : "")},
                  is_alone ? "Check the camera's power and cable, and its network address."
                           : "Use a camera that was found, or check the cable of this one.",
                  std::move(offers));
  }
  Outcome outcome;
  try {
    const Image<float> image = bench.image();
    outcome = passed(fmt::format("{} {}, serial {}, delivers {} x {} pixels; {} found in all.",
                                 text_at(info, "/vendor"), text_at(info, "/model"),
                                 text_at(info, "/serial"), image.width, image.height,
                                 listed.at("cameras").size()));
    outcome.picture = grey_of(image);
  } catch (const StepFailed& failure) {
    outcome = failed(failure.error);
  }
  outcome.offers = std::move(offers);
  return outcome;
}

// Output ------------------------------------------------------------------------------------------

/// Ways to use another output: those that can be the SLM and were not tried. Without any, the
/// selected one although it is the primary one.
std::vector<Offer> other_outputs(const json& outputs, const Memory& memory) {
  std::vector<Offer> offers;
  for (const json& output : outputs) {
    const std::string name = text_at(output, "/name");
    if (output.at("selected") == true || output.at("usable") == false) continue;
    if (memory.tried.contains("use-" + name)) continue;
    offers.push_back({"use-" + name,
                      "use output " + name + " for the SLM",
                      {{"slm.set", {{"display", name}, {"allow_primary", false}}}}});
  }
  return offers;
}

/// Whether the camera's image changes with what the SLM shows, at the exposure for either.
struct Reaction {
  bool changes = false;
  bool is_dark = true;  ///< no light at any exposure
  Image<std::uint8_t> picture;
};
Reaction reaction(Bench& bench) {
  cli::Borrow kept(bench.settings().daemon, bench.parts(kLight), bench.restoring());
  Reaction seen;
  for (const char* bright : {"sensor", "flat"}) {
    const char* const other = bright == std::string("sensor") ? "flat" : "sensor";
    bench.say(fmt::format("looking whether the image changes: {}", bright));
    bench.call("slm.show", {{"pattern", bright}});
    const auto exposed = expose(bench);
    const Image<float> one = bench.image_of(bright);
    const Image<float> two = bench.image_of(other);
    const Image<float> again = bench.image_of(bright);
    seen.picture = grey_of(one);
    seen.changes = change(one, two, again) > 1.0;
    seen.is_dark = seen.is_dark && !exposed && brightest(one) < 0.5F;
    if (seen.changes) break;
  }
  return seen;
}

Outcome unusable(const json& status, const json& outputs, const Memory& memory) {
  const std::string fault = text_at(status, "/fault") + text_at(status, "/slm/fault");
  std::string selected, reason;
  for (const json& output : outputs) {
    if (output.at("selected") == false) continue;
    selected = text_at(output, "/name");
    reason = text_at(output, "/reason");
  }
  std::string text = reason.empty() ? fault : selected + ": " + reason;
  if (text.empty()) text = "The SLM's output is not in use.";
  auto offers = other_outputs(outputs, memory);
  if (!offers.empty()) {
    const std::string advice = "Use " + offers.front().name.substr(4) + ".";
    return failed(text, advice, std::move(offers));
  }
  const bool is_only = std::ranges::count(outputs, json(true), [](const json& output) {
                         return output.at("connected");
                       }) == 1;
  if (is_only && !selected.empty()) {
    offers.push_back({"allow-primary",
                      "use " + selected + " although it is the main display",
                      {{"slm.set", {{"display", selected}, {"allow_primary", true}}}},
                      {},
                      After::rerun,
                      false});
  }
  return failed(text,
                "Connect the SLM as a second display beside the main one, not mirrored, and switch "
                "it on with xrandr.",
                std::move(offers));
}

Outcome no_reaction(const Reaction& seen, const std::string& name, const json& outputs,
                    const Memory& memory) {
  auto outcome =
      seen.is_dark
          ? failed("The camera sees no light, at any exposure and whatever " + name + " shows.",
                   "Switch on the laser, open its shutter, take off the camera's cap, and check "
                   "that the beam reaches the SLM and the camera's region.")
          : failed("The camera's image does not change with what " + name + " shows.",
                   "The SLM may be another output, switched off, or not lit.",
                   other_outputs(outputs, memory));
  outcome.picture = seen.picture;
  outcome.offers.push_back({"identify",
                            "show the test image on " + name + ", to see which screen it is",
                            {{"slm.show", {{"pattern", "identify"}}}},
                            {},
                            After::stay});
  return outcome;
}

Outcome run_output(Bench& bench, Memory& memory) {
  const json slm = bench.call("config.get").at("slm");
  if (!memory.undo) {
    memory.undo = {
        {},
        {{"slm.set", {{"display", slm.at("display")}, {"allow_primary", slm.at("allow_primary")}}}},
        "Output " + text_at(slm, "/display") + " is configured again."};
  }
  const json outputs = bench.call("slm.outputs").at("outputs");
  const json status = bench.call("system.status");
  const json& state = status.at("slm");
  if (state.at("connected") == false) return unusable(status, outputs, memory);
  const std::string name = text_at(state, "/info/output");
  Reaction seen = reaction(bench);
  if (!seen.changes) return no_reaction(seen, name, outputs, memory);
  auto outcome = passed(fmt::format(
      "The camera's image changes with what {} shows: {} x {} pixels at {:.0f} Hz.", name,
      state.at("info").at("width").get<int>(), state.at("info").at("height").get<int>(),
      state.at("info").at("refresh_hz").get<double>()));
  outcome.picture = std::move(seen.picture);
  outcome.offers = other_outputs(outputs, memory);
  return outcome;
}

/// Whether a result of later steps is in use, which machine, camera and output have to work for.
/// None otherwise: the daemon does not tell.
std::optional<bool> has_measured(const Look& look) {
  return done_if(is_true(look, "lut.get", "measured") ||
                 is_true(look, "registration.get", "registered"));
}

/// The same for a device, which is not in use unless it is connected.
std::optional<bool> is_in_use(const Look& look, const char* device) {
  const bool is_connected = look.at("system.status").at(device).at("connected");
  return is_connected ? has_measured(look) : false;
}

const std::array kDeviceSteps{
    Step{"doctor", "This machine",
         "Checks configuration, devices, limits and clock, and proposes a repair for each fault.",
         has_measured, run_doctor},
    Step{"camera", "Camera", "Chooses the camera among those that are found, and shows its image.",
         [](const Look& look) { return is_in_use(look, "camera"); }, run_camera, nullptr, nullptr,
         true},
    Step{"output", "SLM output",
         "Chooses the display output of the SLM, and looks whether the camera's image changes with "
         "what it shows.",
         [](const Look& look) { return is_in_use(look, "slm"); }, run_output, nullptr, nullptr,
         true, Needs::holograms}};

}  // namespace

std::span<const Step> device_steps() {
  return kDeviceSteps;
}

}  // namespace ovws::commission
