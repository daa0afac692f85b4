#include "daemon/ovwsd/sensor/sensor_state.hpp"

#include <algorithm>
#include <string>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/ovwsd/sensor/beams.hpp"

namespace ovws {

bool takes_templates(const SensorState& state) {
  if (state.tracking.tracker == TrackerKind::fit) return state.holder != Holder::job;
  return state.holder == Holder::loop;
}

bool shows_sequence(const SensorState& state) {
  return !state.sequence.empty() && state.pattern == HologramKind::sensor;
}

TrackingSettings tracking_in_use(const SensorState& state) {
  return shows_sequence(state) ? by_positions(state.tracking) : state.tracking;
}

std::vector<Mode> pattern_modes(const SensorState& state, std::size_t pattern) {
  return shown_modes(state.pattern, state.sequence[pattern], state.correction);
}

std::vector<Mode> shown_modes(const SensorState& state) {
  return shown_modes(state.pattern, state.aberration, state.correction);
}

std::uint64_t shown_epoch(const SensorState& state) {
  return state.pattern == HologramKind::sensor ? state.sensor_epoch : 0;
}

bool same_hologram(const SensorState& a, const SensorState& b) {
  return a.sensor == b.sensor && a.slm == b.slm && a.pattern == b.pattern &&
         a.painted == b.painted && shown_modes(a) == shown_modes(b) && a.sequence == b.sequence &&
         a.cycle == b.cycle;
}

namespace {

/// Slot 0 stays dark: the mark.
std::shared_ptr<const Image<std::uint8_t>> sequence_of(const SensorState& state) {
  const HologramConfig& hologram = state.slm->hologram;
  auto rgb =
      std::make_shared<Image<std::uint8_t>>(3 * hologram.slm.width_px, hologram.slm.height_px);
  Image<std::uint8_t> mirrors;
  for (std::size_t k = 0; k < state.sequence.size(); ++k) {
    state.renderer->render(state.pattern, pattern_modes(state, k), mirrors);
    for (int slot = int(k) + 1; slot < state.cycle.slots; slot += int(state.sequence.size())) {
      add_pattern(mirrors, slot, hologram.dmd->bit_order, *rgb);
    }
  }
  return rgb;
}

}  // namespace

std::shared_ptr<const Image<std::uint8_t>> hologram_of(const SensorState& state) {
  if (state.painted) return state.painted;
  if (shows_sequence(state)) return sequence_of(state);
  auto grey = std::make_shared<Image<std::uint8_t>>();
  state.renderer->render(state.pattern, shown_modes(state), *grey);
  return grey;
}

void drop_registration(SensorState& state, const SensorConfig& configured) {
  if (state.registration && !state.registration->array.empty()) state.sensor = configured;
  state.registration.reset();
  ++state.sensor_epoch;
}

Result<void> check_array_found(const SensorConfig& sensor, bool registered) {
  if (sensor.lenslets.empty() || registered) return {};
  return fail(Errc::refused, "registration",
              "the array has not been found yet, and modes would be wrong if it is turned: call "
              "registration.run first");
}

std::optional<Registration> registration_of(const SensorState& state, const BenchOptics& bench) {
  if (!state.registration) return std::nullopt;
  return rebased(*state.registration, base_grating_cpp(state.sensor, bench.slm));
}

/// Converts the registration from pixels of the camera's whole sensor to pixels of the region.
OpticsConfig optics_of(const SensorState& state, const BenchOptics& bench) {
  OpticsConfig optics = bench.optics;
  if (const auto map = registration_of(state, bench)) {
    optics.registered = map->px_per_cycle;
    optics.centre_px = map->base_px - Vec2{double(state.roi.x), double(state.roi.y)};
  }
  return optics;
}

std::vector<Vec2> model_positions(const SensorState& state, const BenchOptics& bench) {
  return model_spots_px(state.renderer->lattice(), state.sensor, bench.slm, optics_of(state, bench),
                        state.roi.width, state.roi.height);
}

double lambda_d_of(const SensorState& state, const BenchOptics& bench) {
  return lambda_d_px(optics_of(state, bench), bench.slm, state.sensor);
}

Result<void> renew_renderer(SensorState& state) {
  HologramConfig hologram = state.slm->hologram;
  hologram.sensor = state.sensor;
  auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  state.renderer = std::make_shared<const HologramRenderer>(std::move(*renderer));
  return {};
}

Result<void> check_sampling(const SensorState& state) {
  if (state.pattern != HologramKind::sensor && state.pattern != HologramKind::grating) return {};
  for (std::size_t k = 0; k < state.sequence.size(); ++k) {
    auto sampled = state.renderer->check_sampling(pattern_modes(state, k));
    if (sampled) continue;
    sampled.error().field = "patterns[" + std::to_string(k) + "].modes";
    return sampled;
  }
  return state.renderer->check_sampling(shown_modes(state));
}

Result<void> check_spots(const SensorState& state, const BenchOptics& bench) {
  const auto lattice = make_lattice(state.sensor, bench.slm);
  if (!lattice) return fail(lattice.error());
  const OpticsConfig optics = optics_of(state, bench);
  const SpotBench spots{*lattice,  state.sensor, state.tracking, optics,
                        bench.slm, state.roi,    state.format};
  if (auto apart = check_spots_apart(spots); !apart) return apart;
  if (auto found = check_spots_found(spots); !found) return found;
  if (auto disjoint = check_beams(spots, bench.beams); !disjoint) return disjoint;
  return check_mode_count(spots);
}

Result<void> check_sources_apart(const SensorState& state, const BenchOptics& bench) {
  const OpticsConfig optics = optics_of(state, bench);
  return check_beams({state.renderer->lattice(), state.sensor, state.tracking, optics, bench.slm,
                      state.roi, state.format},
                     bench.beams);
}

Result<void> check_layout(const SensorState& state, const BenchOptics& bench) {
  if (auto checked = check_spots(state, bench); !checked) return checked;
  const OpticsConfig optics = optics_of(state, bench);
  return check_spots_in_region({state.renderer->lattice(), state.sensor, state.tracking, optics,
                                bench.slm, state.roi, state.format});
}

}  // namespace ovws
