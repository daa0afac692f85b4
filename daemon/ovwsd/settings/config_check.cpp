#include "daemon/ovwsd/settings/config_check.hpp"

#include "core/optics/hologram.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/ovwsd/sensor/beams.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"
#include "daemon/shared/slm_files.hpp"

namespace ovws {
namespace {

Result<void> check_modulator(const Config& config) {
  const bool fixed = config.modulator == Modulator::fixed;
  if (!fixed && config.slm.driver == "none") {
    return fail(Errc::invalid, "slm.driver", "a hologram needs a display: choose sdl");
  }
  if (config.modulator == Modulator::dmd && config.slm.lut) {
    return fail(Errc::invalid, "slm.lut", "a DMD has two levels and no look-up table: set null");
  }
  if (config.modulator != Modulator::dmd && config.dmd.slots > 0) {
    return fail(Errc::invalid, "dmd.slots", "only a DMD has a pattern mode: set modulator to dmd");
  }
  if (!fixed || !config.sensor.lenslets.empty()) return {};
  return fail(Errc::invalid, "array.pitch_um",
              "no lenslet lies in the camera's region and the pupil: check array.pitch_um, "
              "array.pupil_mm, camera.roi and optics.camera_pitch_um");
}

}  // namespace

Result<void> check_usable(const Config& config) {
  if (auto known = check_drivers(config); !known) return known;
  if (auto right = check_modulator(config); !right) return right;
  if (auto there = check_cpus(config.pipeline.cpus); !there) return there;
  const auto hologram = load_hologram_config(config);
  if (!hologram) return fail(hologram.error());
  const auto renderer = HologramRenderer::make(*hologram);
  if (!renderer) return fail(renderer.error());
  if (auto seen = check_sensor(config); !seen) return seen;
  return check_beams(spot_bench(config, renderer->lattice()), config.beams);
}

Result<void> check_sensor(const Config& config) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return fail(lattice.error());
  if (auto fast = check_daemon_tracker(config.tracking); !fast) {
    return fail(fast.error().code, "tracking." + fast.error().field, fast.error().reason);
  }
  const SpotModel spots = spot_model(config.sensor, config.optics, config.slm.geometry,
                                     config.camera.settings.pixel_format);
  const auto tracker = make_tracker(config.tracking, spots);
  if (!tracker) return fail(tracker.error());
  const auto kinds = SpotKinds::make(config.tracking, spots, charges_of(*lattice));
  return kinds ? Result<void>{} : fail(kinds.error());
}

Result<void> check_sees_spots(const Config& config) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return fail(lattice.error());
  const SpotBench bench = spot_bench(config, *lattice);
  if (auto apart = check_spots_apart(bench); !apart) return apart;
  if (auto found = check_spots_found(bench); !found) return found;
  if (auto checked = check_mode_count(bench); !checked) return checked;
  return check_spots_in_region(bench);
}

Result<void> check_zeroth_order(const Config& config) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return fail(lattice.error());
  return check_zeroth_order(spot_bench(config, *lattice));
}

}  // namespace ovws
