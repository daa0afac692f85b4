#include "daemon/config_check.hpp"

#include <algorithm>

#include "core/optics/hologram.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/driver_table.hpp"
#include "daemon/slm_files.hpp"

namespace ovws {
namespace {

Result<void> check_driver(const char* field, const std::string& name,
                          const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return {};
  std::string names;
  for (const auto& one : known) names += (names.empty() ? "" : ", ") + one;
  return fail(Errc::invalid, field, "there is no driver \"" + name + "\": choose one of " + names);
}

}  // namespace

Result<void> check_usable(const Config& config) {
  if (auto known = check_driver("camera.driver", config.camera.driver, camera_driver_names());
      !known) {
    return known;
  }
  if (auto known = check_driver("slm.driver", config.slm.driver, display_driver_names()); !known) {
    return known;
  }
  const auto hologram = load_hologram_config(config);
  if (!hologram) return fail(hologram.error());
  const auto renderer = HologramRenderer::make(*hologram);
  if (!renderer) return fail(renderer.error());
  const SpotModel spots{config.sensor.charge,
                        lambda_d_px(config.optics, config.slm.geometry, config.sensor)};
  const auto tracker = make_tracker(config.tracking, spots);
  if (!tracker) return fail(tracker.error());
  return {};
}

}  // namespace ovws
