#include "drivers/sdl/output.hpp"

#include <algorithm>
#include <string_view>

namespace ovws::sdl {

namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool overlap(const Output& a, const Output& b) {
  return a.on() && b.on() && a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
         b.y < a.y + a.height;
}

constexpr std::string_view kRemedy =
    "; extend the desktop to another output, or set slm.allow_primary";

// Refuses the primary output, because the SLM's window would cover the user's desktop.
Result<void> check_not_primary(const Output& output, const std::vector<Output>& outputs) {
  if (!output.primary) return {};
  return fail(Errc::refused, "slm.display",
              "output " + output.name + " is the primary output" + std::string(kRemedy) +
                  "; there are: " + list_outputs(outputs));
}

Result<void> check_alone(const Output& output, const std::vector<Output>& outputs) {
  if (std::ranges::count_if(outputs, &Output::on) < 2) {
    return fail(Errc::refused, "slm.display",
                "output " + output.name + " is the only output" + std::string(kRemedy));
  }
  for (const Output& other : outputs) {
    if (other.name != output.name && overlap(output, other)) {
      return fail(Errc::refused, "slm.display",
                  "outputs " + output.name + " and " + other.name +
                      " show the same part of the desktop: place one beside the other (xrandr "
                      "--output " +
                      output.name + " --right-of " + other.name + "), or set slm.allow_primary");
    }
  }
  return {};
}

}  // namespace

Result<const Output*> find_output(const std::vector<Output>& outputs, const std::string& wanted) {
  for (const auto name : {&Output::name, &Output::monitor}) {
    const auto matches = std::ranges::count(outputs, wanted, name);
    if (matches == 0 || wanted.empty()) continue;
    if (matches == 1) return &*std::ranges::find(outputs, wanted, name);
    return fail(Errc::refused, "slm.display",
                std::to_string(matches) + " outputs are called \"" + wanted +
                    "\": give a unique name; there are: " + list_outputs(outputs));
  }
  return fail(Errc::unavailable, "slm.display",
              "no output is called \"" + wanted + "\"; there are: " + list_outputs(outputs));
}

Result<Output> choose_output(const std::vector<Output>& outputs, const SdlConfig& config) {
  const auto found = find_output(outputs, config.output);
  if (!found) return fail(found.error());
  const Output& output = **found;
  // Check for the primary output before the mode: if the wrong output is configured, the error must
  // not ask the user to change its mode.
  if (!config.allow_primary) {
    if (const auto other = check_not_primary(output, outputs); !other) return fail(other.error());
  }
  if (const auto mode = check_mode(output, config); !mode) return fail(mode.error());
  if (!config.allow_primary) {
    if (const auto alone = check_alone(output, outputs); !alone) return fail(alone.error());
  }
  return output;
}

Result<void> check_mode(const Output& output, const SdlConfig& config) {
  const std::string remedy = "; set the output's mode with: xrandr --output " + output.name +
                             " --mode " + size_text(config.width, config.height);
  if (!output.on()) {
    return output.connected
               ? fail(Errc::refused, "slm.display",
                      "output " + output.name + " is switched off" + remedy)
               : fail(Errc::unavailable, "slm.display",
                      "nothing is connected to output " + output.name +
                          ": connect and switch on the SLM, or set slm.display to another output");
  }
  if (output.mode_width != config.width || output.mode_height != config.height) {
    return fail(Errc::refused, output.mode_width != config.width ? "slm.width" : "slm.height",
                "output " + output.name + " shows " +
                    size_text(output.mode_width, output.mode_height) + ", the configuration says " +
                    size_text(config.width, config.height) + remedy +
                    ", or slm.width and slm.height if the SLM has no such mode");
  }
  if (output.width != output.mode_width || output.height != output.mode_height || !output.upright) {
    return fail(Errc::refused, "slm.display",
                "output " + output.name +
                    " is scaled, rotated or mirrored, so pixels would not be exact; undo it with: "
                    "xrandr --output " +
                    output.name + " --scale 1x1 --rotate normal --reflect normal");
  }
  return {};
}

std::string list_outputs(const std::vector<Output>& outputs) {
  std::string text;
  for (const Output& output : outputs) {
    if (!output.connected && !output.on()) continue;
    if (!text.empty()) text += ", ";
    text += output.name;
    if (!output.monitor.empty()) text += " \"" + output.monitor + "\"";
    text += output.on() ? " " + size_text(output.width, output.height) : " switched off";
    if (output.primary) text += " (primary)";
  }
  return text.empty() ? "none" : text;
}

std::string edid_monitor_name(std::span<const std::uint8_t> edid) {
  constexpr std::size_t kFirst = 54, kEnd = 126, kLength = 18, kText = 5;
  constexpr std::uint8_t kMonitorName = 0xFC;
  if (edid.size() < 128) return {};
  for (std::size_t at = kFirst; at < kEnd; at += kLength) {
    const auto block = edid.subspan(at, kLength);
    if (block[0] != 0 || block[1] != 0 || block[3] != kMonitorName) continue;
    std::string name(block.begin() + kText, block.end());
    name.erase(std::min(name.find('\n'), name.size()));
    name.erase(name.find_last_not_of(' ') + 1);
    return name;
  }
  return {};
}

}  // namespace ovws::sdl
