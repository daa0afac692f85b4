#include "daemon/web/hologram_image.hpp"

#include <zlib.h>

#include <algorithm>

#include "config/config.hpp"
#include "core/optics/flatness.hpp"
#include "core/optics/hologram.hpp"
#include "daemon/shared/slm_files.hpp"
#include "drivers/png/grey_png.hpp"
#include "proto/json_text.hpp"
#include "proto/names.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

std::vector<Mode> modes_of(const json& list) {
  std::vector<Mode> modes;
  for (const json& mode : list) {
    modes.push_back({mode["j"].get<int>(), mode["waves"].get<double>()});
  }
  return modes;
}

Result<HologramConfig> ingredients(const HologramSources& sources, Config config) {
  config.slm.lut.reset();  // the daemon sends the LUT that it uses
  auto loaded = load_hologram_config(config);
  if (!loaded) {
    return fail(Errc::unavailable, "",
                "ovws-web cannot read the file (" + loaded.error().field + ") on this machine");
  }
  loaded->lut = sources.lut["grey_levels"].get<PhaseLut>();
  if (!sources.flatness["measured"].get<bool>()) return loaded;
  loaded->flatness_waves = flattened(*loaded, modes_of(sources.flatness["modes"]), {},
                                     sources.flatness["pupil_diameter_px"].get<double>());
  return loaded;
}

/// Whether all replies belong to the same hologram.
bool agree(const HologramSources& sources) {
  const json& id = sources.sensor.at("hologram_id");
  return sources.aberration["hologram_id"] == id && sources.correction["hologram_id"] == id;
}

}  // namespace

Result<HologramImagePtr> draw_hologram(const HologramSources& sources) {
  const auto& names = kShowablePatterns();
  const auto name = std::find(names.begin(), names.end(), sources.pattern);
  if (name == names.end()) return fail(Errc::unavailable, "", "a job shows its own patterns");
  if (!sources.aberration["patterns"].empty()) {
    return fail(Errc::unavailable, "", "the DMD shows a sequence of patterns");
  }
  if (!agree(sources)) return fail(Errc::unavailable, "", "the hologram is changing");
  const auto config = parse_config(json_text(sources.config));
  if (!config) return fail(config.error());
  const auto hologram = ingredients(sources, *config);
  if (!hologram) return fail(hologram.error());
  const auto renderer = HologramRenderer::make(*hologram);
  if (!renderer) return fail(renderer.error());
  const auto kind = HologramKind(name - names.begin());
  Image<std::uint8_t> grey;
  renderer->render(kind,
                   shown_modes(kind, modes_of(sources.aberration["modes"]),
                               modes_of(sources.correction["modes"])),
                   grey);
  auto png = encode_grey8_png(grey);
  if (!png) return fail(png.error());
  HologramImage picture;
  picture.hologram_id = sources.sensor.at("hologram_id").get<std::uint64_t>();
  picture.crc32 = std::uint32_t(::crc32(0, grey.pixels.data(), uInt(grey.pixels.size())));
  picture.png = std::move(*png);
  return std::make_shared<const HologramImage>(std::move(picture));
}

}  // namespace ovws::web
