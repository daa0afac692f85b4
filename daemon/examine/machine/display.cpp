#include "daemon/examine/machine/machine.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <thread>

#include "daemon/shared/shell_word.hpp"
#include "drivers/sdl/video.hpp"

namespace ovws::examine {
namespace {

using sdl::DisplayProbe;
using sdl::Output;

constexpr const char* kNoServer = "the X server cannot be queried";
constexpr const char* kNoOutput = "the output was not found";

/// X output of the SLM; null: the X server cannot be queried or lacks this output.
const Output* output_of(const DisplayFacts& facts) {
  if (!facts.probe) return nullptr;
  const auto found = sdl::find_output(facts.probe->outputs, facts.config.output);
  return found ? *found : nullptr;
}

/// Suggests an output for the SLM: connected, not primary, preferably of the configured size.
std::string likely_output(const DisplayProbe& probe, const SdlConfig& config) {
  std::string likely = "NAME";
  for (const Output& output : probe.outputs) {
    if (!output.connected || output.primary) continue;
    const bool fits = output.mode_width == config.width && output.mode_height == config.height;
    if (fits) return output.name;
    if (likely == "NAME") likely = output.name;
  }
  return likely;
}

/// The name of an active output other than the SLM's; empty: none.
std::string other_output(const DisplayProbe& probe, const Output& slm) {
  for (const Output& output : probe.outputs) {
    if (output.on() && output.name != slm.name) return output.name;
  }
  return {};
}

Finding judge_server(const DisplayFacts& facts) {
  if (!facts.probe) {
    const Error& error = facts.probe.error();
    if (error.code == Errc::refused) return not_here(error.reason);
    if (facts.daemon_shows) {
      return not_here(
          "the daemon shows holograms, but this program cannot query its X server: " + error.reason,
          "run ovws doctor with the DISPLAY and XAUTHORITY of the daemon");
    }
    return bad(error.reason,
               facts.server_named ? "sudo systemctl restart display-manager" : "export DISPLAY=:0");
  }
  if (facts.probe->colour_depth_bits == sdl::kExactDepthBits) {
    return good("the X server answers and uses 8 bits per colour");
  }
  return bad(
      fmt::format("the X server's colour depth is {} bits: grey levels on the SLM are not exact",
                  facts.probe->colour_depth_bits),
      fmt::format("DefaultDepth {} in section \"Screen\" of /etc/X11/xorg.conf",
                  sdl::kExactDepthBits));
}

Finding judge_mode(const DisplayFacts& facts) {
  const Output* const found = output_of(facts);
  if (found == nullptr) return not_here(facts.probe ? kNoOutput : kNoServer);
  const Output& output = *found;
  const SdlConfig& config = facts.config;
  const auto fits = sdl::check_mode(output, config);
  const std::string set_mode = fmt::format("xrandr --output {} --mode {}x{}",
                                           shell_word(output.name), config.width, config.height);
  if (output.primary && !config.allow_primary) {
    return not_here(output.name + " is the main display");
  }
  if (fits) {
    return good(fmt::format("{} shows {}x{} at {:.1f} Hz, pixel for pixel", output.name,
                            output.mode_width, output.mode_height, output.refresh_hz));
  }
  if (!output.on()) {
    const std::string other = other_output(*facts.probe, output);
    return bad(output.connected ? "output " + output.name + " is switched off"
                                : "nothing is connected to " + output.name,
               set_mode + (other.empty() ? "" : " --right-of " + shell_word(other)));
  }
  if (output.mode_width != config.width || output.mode_height != config.height) {
    return bad(fmt::format("{} sends {}x{}, but the configured SLM has {}x{}: hologram pixels do "
                           "not match SLM pixels",
                           output.name, output.mode_width, output.mode_height, config.width,
                           config.height),
               set_mode);
  }
  return bad(
      output.name + " is scaled, rotated or mirrored: hologram pixels do not match SLM pixels",
      fmt::format("xrandr --output {} --scale 1x1 --rotate normal --reflect normal",
                  shell_word(output.name)));
}

/// Checks that the X output can be used for the SLM. judge_mode checks the mode of the output.
Finding judge_output(const DisplayFacts& facts) {
  if (!facts.probe) return not_here(kNoServer);
  const std::string choose =
      fmt::format("\"slm\": {{\"display\": \"{}\"}}", likely_output(*facts.probe, facts.config));
  const auto found = sdl::find_output(facts.probe->outputs, facts.config.output);
  if (!found) return bad(found.error().reason, choose);
  const Output& output = **found;
  const auto chosen = sdl::choose_output(facts.probe->outputs, facts.config);
  const bool is_desktop = output.primary && !facts.config.allow_primary;
  if (chosen || (!is_desktop && !sdl::check_mode(output, facts.config))) {
    return good("output " + output.name + " exists");
  }
  const std::string& reason = chosen.error().reason;
  if (is_desktop) {
    return bad(reason, choose);
  }
  const std::string other = other_output(*facts.probe, output);
  if (other.empty()) return bad(reason, "\"slm\": {\"allow_primary\": true}");
  return bad(reason, fmt::format("xrandr --output {} --right-of {}", shell_word(output.name),
                                 shell_word(other)));
}

Finding judge_gamma(const DisplayFacts& facts) {
  const Output* const found = output_of(facts);
  if (found == nullptr) return not_here(facts.probe ? kNoOutput : kNoServer);
  const Output& output = *found;
  if (!output.on()) return not_here(output.name + " is switched off");
  if (output.linear_gamma) return good("the gamma ramp of " + output.name + " is linear");
  return bad("the gamma ramp of " + output.name +
                 " is not linear, so that the SLM gets wrong grey levels; stop the night light or "
                 "colour management that sets it",
             fmt::format("xrandr --output {} --gamma 1:1:1", shell_word(output.name)));
}

Finding judge_power(const DisplayFacts& facts) {
  if (!facts.probe) return not_here(kNoServer);
  if (facts.probe->asleep) {
    return bad("the screens are powered down", "xset dpms force on && xset -dpms");
  }
  if (!facts.probe->power_saving) return good("DPMS does not power the screens down");
  return warning(
      "DPMS powers the screens down when the desktop is idle; a daemon prevents it only "
      "while it shows a hologram",
      "xset -dpms");
}

Finding judge_screen_saver(const DisplayFacts& facts) {
  if (!facts.probe) return not_here(kNoServer);
  if (facts.probe->screen_saver_s == 0) return good("the X server's screen saver is off");
  return warning(fmt::format("the screen saver blanks the screens after {} s without input; a "
                             "daemon prevents it only while it shows a hologram",
                             facts.probe->screen_saver_s),
                 "xset s off");
}

Finding judge_compositor(const DisplayFacts& facts) {
  if (!facts.probe) return not_here(kNoServer);
  if (!facts.probe->composited) return good("no compositing manager is running");
  return warning(
      "a compositing manager is running and may delay holograms by one or two frames; "
      "switch it off, or measure the delay and set slm.settle_ms",
      "ovws call --wait slm.settle");
}

/// Probes the display with a timeout. Xlib blocks forever on a server that hangs, so the probe runs
/// in a detached thread that ends with the process.
Result<DisplayProbe> probe_in_time() {
  constexpr std::chrono::seconds kProbeTimeout{3};
  std::packaged_task<Result<DisplayProbe>()> probe(sdl::probe_display);
  auto found = probe.get_future();
  std::thread(std::move(probe)).detach();
  if (found.wait_for(kProbeTimeout) == std::future_status::ready) return found.get();
  return fail(Errc::unavailable, "slm.display",
              fmt::format("the X server DISPLAY={} does not answer within {} s: it hangs, restart "
                          "it",
                          sdl::environment("DISPLAY"), kProbeTimeout.count()));
}

}  // namespace

DisplayFacts read_display(const SlmConfig& config, bool daemon_shows) {
  return {
      {config.display, config.geometry.width_px, config.geometry.height_px, config.allow_primary},
      probe_in_time(),
      std::getenv("DISPLAY") != nullptr,
      daemon_shows};
}

Findings answers(const DisplayFacts& facts) {
  constexpr Question<DisplayFacts> kQuestions[] = {
      {"slm.server", judge_server},
      {"slm.output", judge_output, kLater},
      {"slm.mode", judge_mode},
      {"slm.gamma", judge_gamma},
      {"slm.power", judge_power},
      {"slm.screen_saver", judge_screen_saver},
      {"slm.compositor", judge_compositor},
  };
  return answers<DisplayFacts>(kQuestions, facts);
}

}  // namespace ovws::examine
