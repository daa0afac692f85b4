#include "daemon/procedures/lut.hpp"

#include <array>
#include <cmath>

#include "core/optics/grey_fringe.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

/// Of a subaperture's diameter: the largest that saturates nothing is taken.
constexpr std::array<double, 5> kShares{1.0, 0.7, 0.5, 0.35, 0.25};
constexpr std::array<int, 8> kTrials{128, 160, 192, 224, 255, 96, 64, 32};
constexpr double kLeastContrast = 4.0;  // brightest pixel over that of the darkest trial

/// One bench, and the patches that suit its light.
class LutBench {
 public:
  LutBench(Bench& bench, const SlmGeometry& slm, int frames)
      : bench_(bench),
        slm_(slm),
        frames_(frames),
        now_(bench.sensor()),
        map_(px_per_cycle(now_.optics, slm)) {}

  Result<FringeReading> read(const FringePatches& patches, int grey, int fixed);
  /// Finds patches that saturate nothing, and the fixed grey level that is brightest.
  Result<void> choose();
  Result<std::complex<double>> beat(int grey);

 private:
  Result<bool> try_share(double share);

  Bench& bench_;
  SlmGeometry slm_;
  int frames_;
  SensorSnapshot now_;
  PxPerCycle map_;
  FringePatches patches_;
  int fixed_ = 0;
};

Result<FringeReading> LutBench::read(const FringePatches& patches, int grey, int fixed) {
  // By value: once the job was cancelled the painter may be called after this has returned.
  const auto paint = [patches, sensor = now_.sensor, slm = slm_, grey, fixed](
                         const HologramRenderer&, Image<std::uint8_t>& picture) {
    draw_fringe_patches(patches, sensor, slm, grey, fixed, picture);
  };
  if (auto shown = bench_.show(paint); !shown) return fail(shown.error());
  const auto light = bench_.picture(frames_);
  if (!light) return fail(light.error());
  return read_fringe(*light, patches, base_spot_px(now_.optics, light->width, light->height), map_);
}

/// False: something is saturated.
Result<bool> LutBench::try_share(double share) {
  patches_ = fringe_patches(now_.sensor, map_, share);
  const auto dark = read(patches_, 0, 0);
  if (!dark) return fail(dark.error());
  double most = 0.0;
  for (const int grey : kTrials) {
    const auto seen = read(patches_, grey, grey);
    if (!seen) return fail(seen.error());
    if (seen->saturated) return false;
    if (seen->brightest_dn <= most) continue;
    most = seen->brightest_dn;
    fixed_ = grey;
  }
  if (most > kLeastContrast * std::max(1.0, dark->brightest_dn)) return true;
  return fail(Errc::refused, "camera.exposure_us",
              "no light comes where the base spot belongs: run registration.run, or raise the "
              "exposure");
}

Result<void> LutBench::choose() {
  for (const double share : kShares) {
    const auto fits = try_share(share);
    if (!fits) return fail(fits.error());
    if (*fits) return {};
  }
  return fail(Errc::refused, "camera.exposure_us",
              "the spot is saturated: lower the exposure or the gain");
}

Result<std::complex<double>> LutBench::beat(int grey) {
  const auto seen = read(patches_, grey, fixed_);
  if (!seen) return fail(seen.error());
  if (!seen->saturated) return seen->beat;
  return fail(Errc::refused, "camera.exposure_us",
              "the spot is saturated: lower the exposure or the gain");
}

}  // namespace

Result<MeasuredLut> measure_lut(Bench& bench, const SlmGeometry& slm, const LutRun& run) {
  LutBench lut_bench(bench, slm, run.frames);
  if (auto chosen = lut_bench.choose(); !chosen) return fail(chosen.error());
  std::vector<GreyBeat> beats;
  for (int k = 0; k < run.levels; ++k) {
    beats.push_back({int(std::lround(255.0 * k / (run.levels - 1))), {}, {}});
  }
  // Up and down again: what drifts meanwhile shows between the two.
  for (int k = 0; k < 2 * run.levels; ++k) {
    bench.tell(double(k + 1) / (2 * run.levels + 1));
    const bool up = k < run.levels;
    GreyBeat& beat = beats[std::size_t(up ? k : 2 * run.levels - 1 - k)];
    const auto seen = lut_bench.beat(beat.grey);
    if (!seen) return fail(seen.error());
    (up ? beat.first : beat.second) = *seen;
  }
  auto response = phase_response(beats);
  if (!response) return fail(response.error());
  MeasuredLut lut;
  lut.t_taken_ns = utc_ns();
  lut.frames = run.frames;
  lut.table = linearising_lut(response->phase_rad);
  lut.response = std::move(*response);
  return lut;
}

}  // namespace ovws
