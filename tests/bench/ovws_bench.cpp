/// Micro-benchmarks of the work per frame, with reference loops in the same run. Compare ratios:
///   ovws_bench --benchmark_format=json
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>

#include "core/optics/hologram.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/lg_contour.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "tests/bench/spot_field.hpp"

namespace ovws::bench {
namespace {

using benchmark::State;

void mark(State& state) {
  const SpotField field(int(state.range(0)), int(state.range(1)), 1);
  for (auto _ : state) benchmark::DoNotOptimize(centroid_mark(field));
}

void track(State& state, TrackerKind kind) {
  const SpotField field(int(state.range(0)), int(state.range(1)), 1);
  const auto tracker = make_tracker({kind}, field.spots).value();
  TrackScratch scratch = tracker->make_scratch();
  int found = 0;
  for (auto _ : state) {
    found = 0;
    for (const Vec2 start : field.middles_px) {
      found += tracker->track(field.view(), start, scratch).found() ? 1 : 0;
    }
    benchmark::DoNotOptimize(found);
  }
  if (found != int(field.middles_px.size())) state.SkipWithError("spots were lost");
}

/// A whole frame by templates: all spots and the modes.
void fit(State& state) {
  constexpr int kModes = 18;
  const SpotField field(int(state.range(0)), int(state.range(1)), 1);
  OperatingPoint point;
  point.waves.assign(kModes, 0.0);
  point.reference_waves.assign(kModes, 0.0);
  point.noise.constant_dn2 = 1600.0;
  point.lit = int(field.middles_px.size());
  point.levels_dn.assign(field.middles_px.size(), kPeakDn);
  point.ceiling_dn = 65000.0;
  point.max_excess = 100.0;  // the spots stand elsewhere
  std::vector<int> modes_j(kModes);
  std::iota(modes_j.begin(), modes_j.end(), 1);
  const FrameFit frame(point, rendered(field), modes_j);
  SpotFit::Scratch pixels = frame.spots().make_scratch();
  FrameFit::Scratch scratch = frame.make_scratch();
  std::vector<SpotEstimates> found(field.middles_px.size());
  std::vector<SpotFix> fixes(found.size());
  std::vector<float> coefficients(kModes), sigma_waves(kModes);
  for (auto _ : state) {
    for (std::size_t i = 0; i < found.size(); ++i)
      found[i] = frame.spots().fit(field.view(), i, pixels);
    benchmark::DoNotOptimize(frame.solve(found, scratch, coefficients, sigma_waves, fixes));
  }
}

/// Tracks noise without spots, of the same level as beside the spots.
void track_lost(State& state) {
  SpotField field(int(state.range(0)), int(state.range(1)), 1);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(100.0, 40.0);
  for (auto& pixel : field.picture.pixels) {
    pixel = std::uint16_t(std::clamp(noise(random), 0.0, 4095.0));
  }
  const auto tracker = make_tracker({TrackerKind::lg}, field.spots).value();
  TrackScratch scratch = tracker->make_scratch();
  int found = 0;
  for (auto _ : state) {
    for (const Vec2 start : field.middles_px) {
      found += tracker->track(field.view(), start, scratch).found() ? 1 : 0;
    }
    benchmark::DoNotOptimize(found);
  }
  if (found != 0) state.SkipWithError("noise was taken for a spot");
}

void acquire_cold(State& state) {
  const SpotField field(int(state.range(0)), int(state.range(1)), 1);
  const auto tracker = make_tracker({TrackerKind::lg}, field.spots).value();
  TrackScratch scratch = tracker->make_scratch();
  Acquisition acquisition(field.spots, field.middles_px, field.picture.width, field.picture.height);
  std::vector<SpotFix> fixes(field.middles_px.size());
  int found = 0;
  for (auto _ : state) found = acquisition.acquire(field.view(), *tracker, scratch, fixes);
  if (found != int(fixes.size())) state.SkipWithError("spots were not found");
}

void reconstruct(State& state) {
  const int spots = int(state.range(0));
  const int across = int(std::lround(std::sqrt(spots / 0.76)));
  const int modes = optimal_mode_count(across);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd slopes =
      Eigen::MatrixXd::NullaryExpr(2 * spots, modes, [&] { return normal(random); });
  std::vector<int> modes_j;
  for (int j = 1; j <= modes; ++j) modes_j.push_back(j);
  std::vector<SpotFix> fixes;
  for (int i = 0; i < spots; ++i) {
    fixes.push_back({});
    fixes.back().x = float(i);
    fixes.back().y = float(2 * i);
  }
  const Reconstructor reconstructor(slopes, modes_j, std::vector<Vec2>(std::size_t(spots)));
  Reconstructor::Scratch scratch = reconstructor.make_scratch();
  std::vector<float> coefficients(modes_j.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(reconstructor.solve(fixes, scratch, coefficients));
  }
}

void hologram(State& state) {
  HologramConfig config;
  config.slm.width_px = int(state.range(0));
  config.slm.height_px = int(state.range(1));
  config.sensor.pupil_diameter_px = config.slm.height_px;
  config.flatness_waves =
      std::make_shared<Image<float>>(config.slm.width_px, config.slm.height_px, 0.3F);
  for (std::size_t k = 0; k < config.lut.size(); ++k) config.lut[k] = std::uint8_t(220 * k / 255);
  const auto renderer = HologramRenderer::make(config).value();
  std::vector<Mode> modes;
  for (int j = 1; j <= 18; ++j) modes.push_back({j, 0.02 * j});
  Image<std::uint8_t> grey;
  for (auto _ : state) {
    renderer.render(HologramKind::sensor, modes, grey);
    benchmark::DoNotOptimize(grey.pixels.data());
  }
}

/// Diffraction model of the default bench, for a number of modes.
SpotRenderer renderer_of(int modes) {
  constexpr int kImagePx = 512;
  std::vector<int> modes_j(modes);
  std::iota(modes_j.begin(), modes_j.end(), 1);
  return SpotRenderer::make({}, {}, {}, kImagePx, kImagePx, modes_j, {}).value();
}

/// Renders all spots with their derivatives.
void render(State& state) {
  SpotRenderer renderer = renderer_of(int(state.range(0)));
  std::vector<double> waves(std::size_t(state.range(0)), 0.02);
  for (auto _ : state) {
    waves[3] = -waves[3];
    benchmark::DoNotOptimize(renderer.render(waves));
  }
}

/// Makes the templates of rendered spots.
void templates(State& state) {
  const std::vector<double> waves(std::size_t(state.range(0)), 0.02);
  const std::vector<RenderedSpot> spots = renderer_of(int(state.range(0))).render(waves);
  const std::vector<CellLevel> levels(spots.size(), CellLevel{kPeakDn, 65000.0});
  const PixelNoise noise{25.0, 1.0};
  for (auto _ : state) {
    benchmark::DoNotOptimize(make_templates(spots, levels, noise, kMaxSpotEstimates));
  }
}

/// Reference: copies one 32-bit frame.
void memcpy_mark(State& state) {
  const std::vector<std::uint32_t> from(std::size_t(state.range(0) * state.range(1)), 7U);
  std::vector<std::uint32_t> to(from.size());
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size() * sizeof from[0]);
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
}

void regions(benchmark::internal::Benchmark* b) {
  b->ArgsProduct({{19, 91, 400}, {32, 64}})->Unit(benchmark::kMicrosecond);
}
void screens(benchmark::internal::Benchmark* b) {
  b->Args({1280, 768})->Args({1920, 1080})->Args({3840, 2160})->Unit(benchmark::kMicrosecond);
}

BENCHMARK(mark)->Name("BM_CentroidMark")->Apply(regions);
BENCHMARK_CAPTURE(track, lg, TrackerKind::lg)->Name("BM_Lg")->Apply(regions);
BENCHMARK(fit)->Name("BM_Fit")->Apply(regions);
BENCHMARK(track_lost)->Name("BM_LgLost")->Apply(regions);
BENCHMARK_CAPTURE(track, lg_contour, TrackerKind::lg_contour)->Name("BM_LgContour")->Apply(regions);
BENCHMARK(acquire_cold)->Name("BM_AcquireCold")->Apply(regions);
BENCHMARK(reconstruct)
    ->Name("BM_Reconstruct")
    ->Arg(19)
    ->Arg(91)
    ->Arg(400)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(render)->Name("BM_Render")->Arg(18)->Arg(44)->Unit(benchmark::kMicrosecond);
BENCHMARK(templates)->Name("BM_Templates")->Arg(18)->Arg(44)->Unit(benchmark::kMicrosecond);
BENCHMARK(hologram)->Name("BM_Hologram")->Apply(screens);
BENCHMARK(memcpy_mark)->Name("BM_MemcpyMark")->Apply(screens);

}  // namespace
}  // namespace ovws::bench

BENCHMARK_MAIN();
