#include "drivers/sdl/display_probe.hpp"
#include "drivers/sdl/sdl_display.hpp"
#include "drivers/sdl/video.hpp"

namespace ovws {

Result<std::vector<DisplayOutput>> list_sdl_outputs(const SdlConfig& config) {
  const auto probe = sdl::probe_display();
  if (!probe) return fail(probe.error());
  const auto selected = sdl::find_output(probe->outputs, config.output);
  std::vector<DisplayOutput> all;
  for (const sdl::Output& output : probe->outputs) {
    SdlConfig this_one = config;
    this_one.output = output.name;
    const auto usable = sdl::choose_output(probe->outputs, this_one);
    all.push_back({output.name, output.monitor, output.connected, output.on(), output.primary,
                   output.mode_width, output.mode_height, output.refresh_hz,
                   usable ? "" : usable.error().reason, selected && *selected == &output});
  }
  return all;
}

Result<void> check_sdl_output(const SdlConfig& config) {
  const auto driver = sdl::choose_driver();
  if (!driver) return fail(driver.error());
  if (*driver != "x11") return {};
  const auto probe = sdl::probe_display();
  if (!probe) return fail(probe.error());
  const auto chosen = sdl::choose_output(probe->outputs, config);
  if (!chosen) return fail(chosen.error());
  return {};
}

}  // namespace ovws
