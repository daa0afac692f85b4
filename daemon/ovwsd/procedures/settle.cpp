#include "daemon/ovwsd/procedures/measurements.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/pixels.hpp"
#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/procedures/probes.hpp"

namespace ovws {
namespace {

constexpr double kAsideLambdaD = 3.0;  // lambda/d to each side of the base spot
constexpr double kRadius = 1.5;  // lambda/d: half-width of the square whose intensity is averaged
constexpr int kBefore = 3, kAfter = 24;  // least frames before and after each change
constexpr int kMaxDisturbed = 2;         // moves, by frames that a busy machine delayed

constexpr std::size_t kMaxFrames = 100'000;  // recorded for each change

struct ToAndFro {
  std::array<Vec2, 2> frequencies_cpp, places_px;
  double radius_px =
      0.0;  ///< half-width of the square around each place, whose intensity is averaged
  int charge = 0;
};

ToAndFro to_and_fro(const SensorSnapshot& now, const SlmGeometry& slm, const Roi& roi) {
  const PxPerCycle map = px_per_cycle(now.optics, slm);
  const Vec2 base_cpp = base_grating_cpp(now.sensor, slm);
  const Vec2 base_px = base_spot_px(now.optics, roi.width, roi.height);
  const double lambda_px = lambda_d_px(now.optics, slm, now.sensor);
  const double aside = kAsideLambdaD * lambda_px / map.scale();
  ToAndFro moves;
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec2 offset{k == 0 ? -aside : aside, 0.0};
    moves.frequencies_cpp[k] = base_cpp + offset;
    moves.places_px[k] = base_px + map * offset;
  }
  moves.radius_px = kRadius * lambda_px;
  moves.charge = std::clamp(now.sensor.charge, -kMaxProbeCharge, kMaxProbeCharge);
  return moves;
}

struct Seen {
  std::int64_t t_device_ns = 0;
  std::int64_t t_arrival_mono_ns = 0;
  double exposure_us = 0.0;
  std::array<double, 2> mean_dn{};  ///< mean of the pixels around each place
};

double mean_around(const ImageView& image, Vec2 place, double radius_px) {
  const int left = std::max(0, int(std::ceil(place.x - radius_px)));
  const int right = std::min(image.width - 1, int(std::floor(place.x + radius_px)));
  const int top = std::max(0, int(std::ceil(place.y - radius_px)));
  const int bottom = std::min(image.height - 1, int(std::floor(place.y + radius_px)));
  double sum = 0.0;
  const int columns = std::max(0, right - left + 1), rows = std::max(0, bottom - top + 1);
  visit_rows(image, left, top, columns, rows, [&](int, int, const auto* pixels, int count) {
    for (int i = 0; i < count; ++i) sum += double(pixels[i]);
  });
  const int count = columns * rows;
  return count > 0 ? sum / count : 0.0;
}

Seen seen_in(const FrameRecord& record, const ToAndFro& moves) {
  const GrabbedFrame& frame = record.frame;
  Seen seen{frame.t_device_ns, frame.t_arrival_mono_ns, record.exposure_us, {}};
  for (std::size_t k = 0; k < 2; ++k) {
    seen.mean_dn[k] = mean_around(frame.image, moves.places_px[k], moves.radius_px);
  }
  return seen;
}

/// Exposure start times by the camera's clock (if it has none, by arrival), ms after the
/// presentation. Queues do not delay that clock. The frame with the shortest delay is assumed to
/// arrive at the end of its exposure.
std::vector<StepFrame> after(const std::vector<Seen>& seen, std::int64_t presented_ns) {
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

/// Shows the spot at one of its places.
Result<void> show_at(Bench& bench, const ToAndFro& moves, std::size_t place) {
  const Probe probe{moves.frequencies_cpp[place], moves.charge};
  return bench.show([probe](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
    renderer.render_probe(probe, grey);
  });
}

/// Shows the spot at one of its places until it stands there, which may take longer than
/// slm.settle_ms says.
Result<void> rest_at(Bench& bench, const ToAndFro& moves, std::size_t place, double watch_ms) {
  if (auto shown = show_at(bench, moves, place); !shown) return shown;
  const auto watch = bench.watch([](const FrameRecord&) { return true; });
  return bench.wait_watching(watch, watch_ms, 1);
}

/// Moves the spot to one of its places and watches the light.
Result<StepTime> watch_move(Bench& bench, const ToAndFro& moves, std::size_t place,
                            double watch_ms) {
  std::vector<Seen> seen;
  auto watch = bench.watch([&](const FrameRecord& record) {
    if (!record.settings_known || seen.size() == kMaxFrames) return false;
    seen.push_back(seen_in(record, moves));
    return true;
  });
  if (auto some = bench.wait_watching(watch, 0.0, kBefore); !some) return fail(some.error());
  if (auto shown = show_at(bench, moves, place); !shown) return fail(shown.error());
  const std::int64_t presented_ns = bench.presented_mono_ns();
  if (auto all = bench.wait_watching(watch, watch_ms, kAfter); !all) return fail(all.error());
  if (auto stands = bench.check_shown(presented_ns); !stands) return fail(stands.error());
  watch.close();
  const auto frames = after(seen, presented_ns);
  // The first frame gives the level before the change. The last frame before the change is
  // unsafe: a camera that stamps late may place it after the change.
  return step_time(frames, frames.front().light);
}

}  // namespace

Result<SettleTime> measure_settle(Bench& bench, const SettleRun& run) {
  const ToAndFro moves = to_and_fro(*bench.sensor(), bench.geometry(), bench.camera().settings.roi);
  if (auto rests = rest_at(bench, moves, 0, run.watch_ms); !rests) return fail(rests.error());
  std::vector<StepTime> steps;
  int disturbed = 0;
  for (std::size_t place = 1; int(steps.size()) < run.repetitions;) {
    bench.report_progress(double(steps.size() + 1) / (run.repetitions + 1));
    const auto step = watch_move(bench, moves, place, run.watch_ms);
    if (step) {
      steps.push_back(*step);
      place = 1 - place;
      continue;
    }
    if (step.error().field != "watch_ms" || ++disturbed > kMaxDisturbed) return fail(step.error());
    bench.warn("slm", "slm.settle repeats a change, because " + step.error().reason, {});
    if (auto back = rest_at(bench, moves, 1 - place, run.watch_ms); !back) {
      return fail(back.error());
    }
  }
  return settle_time(steps);
}

}  // namespace ovws
