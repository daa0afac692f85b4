#include "daemon/ovws/study/cloud.hpp"

#include <cmath>
#include <random>

#include "core/spots/spot_templates.hpp"

namespace ovws::study {
namespace {

constexpr int kCropHalfPx = 64;

Image<float> crop(const Image<float>& light, Vec2 centre, Vec2& at) {
  const int x0 = int(std::lround(centre.x)) - kCropHalfPx;
  const int y0 = int(std::lround(centre.y)) - kCropHalfPx;
  Image<float> out(2 * kCropHalfPx + 1, 2 * kCropHalfPx + 1);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) out.at(x, y) = light.at(x0 + x, y0 + y);
  }
  at = centre - Vec2{double(x0), double(y0)};
  return out;
}

constexpr int kBoundHalfPx = 26;

}  // namespace

SpotBench spot_bench(const Method& method, Light light, const SensorPair& sensors) {
  const auto& model = sensors.of(method.charge);
  SpotBench bench{
      light, method, std::make_shared<Measurer>(default_bench(), method, model), {}, {}};
  const auto base = std::size_t(bench.measurer->spots() / 2);
  Vec2 centre = bench.measurer->reference_px()[base];
  if (std::isnan(centre.x)) centre = model->spots_px()[base];  // not found even without noise
  bench.light_e = crop(sensors.electrons(method.charge, {}, light), centre, bench.at_px);
  return bench;
}

std::vector<SpotBench> all_spot_benches() {
  const SensorPair sensors(default_bench());
  std::vector<SpotBench> all;
  for (const Light light : kLights) {
    for (const Method& method : all_methods()) {
      if (method.fixed_cell) continue;  // one cropped spot has no fixed window
      all.push_back(spot_bench(method, light, sensors));
    }
  }
  return all;
}

Cloud cloud_of(const SpotBench& bench, double read_noise_e, int realisations, std::uint64_t seed) {
  Cloud cloud;
  std::mt19937_64 random(seed);
  const double reach_px = kStartWithin * bench.measurer->lambda_d_px();
  std::uniform_real_distribution<double> within(-reach_px, reach_px);
  for (int k = 0; k < realisations; ++k) {
    const std::vector<Vec2> start{bench.at_px + Vec2{within(random), within(random)}};
    const Vec2 truth = bench.measurer->noise_free_px(bench.light_e, start).front();
    const Exposure exposure = expose(bench.light_e, read_noise_e, random());
    const SpotFix fix = bench.measurer->track(exposure, start).front();
    if (!fix.found() || std::isnan(truth.x)) {
      ++cloud.lost;
      continue;
    }
    const Vec2 error{fix.x - truth.x, fix.y - truth.y};
    cloud.x_px.push_back(error.x);
    cloud.y_px.push_back(error.y);
    cloud.squares_px2.push_back(0.5 * (error.x * error.x + error.y * error.y));
  }
  return cloud;
}

double bound_px(const SpotBench& bench, double read_noise_e) {
  const int left = int(std::lround(bench.at_px.x)) - kBoundHalfPx;
  const int top = int(std::lround(bench.at_px.y)) - kBoundHalfPx;
  RenderedSpot spot;
  spot.window = {left, top, 2 * kBoundHalfPx + 1, 1};
  spot.light.resize(spot.window.cells());
  spot.per_px.resize(spot.window.cells(), 2);
  for (int c = 0; c < spot.window.cells(); ++c) {
    const int x = left + c % spot.window.side, y = top + c / spot.window.side;
    const auto value = [&](int dx, int dy) { return bench.light_e.at(x + dx, y + dy); };
    // Fourth-order central differences suffice: the image has no detail finer than lambda/d.
    spot.light(c) = value(0, 0);
    spot.per_px(c, 0) = (8 * (value(-1, 0) - value(1, 0)) - (value(-2, 0) - value(2, 0))) / 12;
    spot.per_px(c, 1) = (8 * (value(0, -1) - value(0, 1)) - (value(0, -2) - value(0, 2))) / 12;
  }
  spot.per_wave = spot.per_px;
  const std::vector<CellLevel> level{{1.0}};
  return make_templates({&spot, 1}, level, {read_noise_e * read_noise_e, 1.0}, 2).front().px_error;
}

}  // namespace ovws::study
