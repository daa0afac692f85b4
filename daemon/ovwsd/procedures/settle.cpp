#include "daemon/ovwsd/procedures/measurements.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

constexpr double kStep = 3.0;            // lambda/d to each side of the base spot
constexpr double kRadius = 1.5;          // lambda/d: of the light that counts
constexpr int kMaxCharge = 2;            // of a probe
constexpr int kBefore = 3, kAfter = 24;  // frames of each picture, at least

struct ToAndFro {
  std::array<Vec2, 2> frequencies_cpp, places_px;
  double radius_px = 0.0;
  int charge = 0;
};

ToAndFro to_and_fro(const SensorSnapshot& now, const SlmGeometry& slm, const Roi& roi) {
  const PxPerCycle map = px_per_cycle(now.optics, slm);
  const Vec2 base_cpp = base_grating_cpp(now.sensor, slm);
  const Vec2 base_px = base_spot_px(now.optics, roi.width, roi.height);
  const double lambda_px = lambda_d_px(now.optics, slm, now.sensor);
  const double aside = kStep * lambda_px / map.scale();
  ToAndFro moves;
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec2 offset{k == 0 ? -aside : aside, 0.0};
    moves.frequencies_cpp[k] = base_cpp + offset;
    moves.places_px[k] = base_px + map * offset;
  }
  moves.radius_px = kRadius * lambda_px;
  moves.charge = std::clamp(now.sensor.charge, -kMaxCharge, kMaxCharge);
  return moves;
}

/// Exposures by the camera's own clock, which knows no queue: the frame that came soonest after its
/// stamp came at the end of its exposure.
std::vector<StepFrame> after(const std::vector<IntensityFrame>& seen, std::int64_t presented_ns) {
  std::int64_t soonest_ns = std::numeric_limits<std::int64_t>::max();
  bool stamped = true;
  for (const auto& one : seen) {
    stamped = stamped && one.t_device_ns != 0;
    soonest_ns = std::min(soonest_ns, one.t_arrival_mono_ns - one.t_device_ns);
  }
  std::vector<StepFrame> frames;
  for (const auto& one : seen) {
    const std::int64_t end_ns = stamped ? one.t_device_ns + soonest_ns : one.t_arrival_mono_ns;
    frames.push_back({1e-6 * double(end_ns - presented_ns) - 1e-3 * one.exposure_us,
                      one.mean_dn[1] - one.mean_dn[0]});
  }
  return frames;
}

}  // namespace

Result<SettleTime> measure_settle(Bench& bench, const SlmGeometry& slm, const SettleRun& run) {
  const ToAndFro moves = to_and_fro(*bench.sensor(), slm, bench.camera().settings.roi);
  const auto show = [&](std::size_t place) {
    const Probe probe{moves.frequencies_cpp[place], moves.charge};
    return bench.show([probe](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
      renderer.render_probe(probe, grey);
    });
  };
  if (auto shown = show(0); !shown) return fail(shown.error());
  if (auto stands = bench.picture(1); !stands) return fail(stands.error());
  std::vector<StepTime> steps;
  for (int k = 1; k <= run.repetitions; ++k) {
    bench.report_progress(double(k) / (run.repetitions + 1));
    IntensityWatch watch = bench.watch(moves.places_px, moves.radius_px);
    if (auto seen = bench.wait_watching(watch, 0.0, kBefore); !seen) return fail(seen.error());
    if (auto shown = show(std::size_t(k % 2)); !shown) return fail(shown.error());
    const std::int64_t presented_ns = bench.presented_mono_ns();
    if (auto seen = bench.wait_watching(watch, run.watch_ms, kAfter); !seen)
      return fail(seen.error());
    if (auto stands = bench.check_shown(presented_ns); !stands) return fail(stands.error());
    const auto frames = after(watch.end(), presented_ns);
    // The first one: a camera that stamps late may place the last one before the change behind it.
    const auto step = step_time(frames, frames.front().light);
    if (!step) return fail(step.error());
    steps.push_back(*step);
  }
  return settle_time(steps);
}

}  // namespace ovws
