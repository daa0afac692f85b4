#include "daemon/ovwsd/procedures/measurements.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/optics/grey_fringe.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

/// Patch diameters to try, relative to a subaperture. The largest that does not saturate is used.
constexpr std::array<double, 5> kRelativeDiameters{1.0, 0.7, 0.5, 0.35, 0.25};
constexpr std::array<int, 8> kTrials{128, 160, 192, 224, 255, 96, 64, 32};
constexpr double kMinContrast = 3.0;  // brightest pixel relative to the brightest at grey level 0

Error no_spot() {
  return {Errc::refused, "camera.exposure_us",
          "there is no spot where the base spot is expected: run registration.run, raise the "
          "laser's power, or check that slm.settle_ms is long enough (slm.settle measures it)"};
}

/// Shows the patches and reads their interference fringes.
class LutBench {
 public:
  LutBench(Bench& bench, int frames)
      : bench_(bench),
        slm_(bench.geometry()),
        frames_(frames),
        now_(bench.sensor()),
        map_(px_per_cycle(now_->optics, slm_)) {}

  /// Chooses exposure and patches: the largest that do not saturate. The grey level with the
  /// brightest spot becomes the fixed level.
  Result<void> choose() {
    bool was_saturated = false;
    for (int steps = 0; steps <= kMaxExposureSteps; ++steps) {
      const auto fit = try_exposure();
      if (!fit) return fail(fit.error());
      if (*fit == Fit::good) return {};
      if (*fit == Fit::invisible && was_saturated) return fail(no_spot());
      was_saturated = *fit == Fit::saturated;
      if (steps == kMaxExposureSteps) break;
      const auto changed =
          change_exposure(bench_, was_saturated ? 1.0 / kExposureStep : kExposureStep);
      if (!changed) return fail(changed.error());
      if (!*changed) break;
    }
    return fail(was_saturated ? saturated_spot() : no_spot());
  }

  /// Finds the direction of the fringes, unless the registration tells it.
  Result<void> find_direction() {
    if (now_->registration) return {};
    const auto light = picture(fringes(fixed_, fixed_));
    if (!light) return fail(light.error());
    map_ = find_fringe_rotation(
        *light, patches_, base_spot_px(now_->optics, light->width, light->height), map_.scale());
    return {};
  }

  Result<std::complex<double>> beat(int grey) {
    const auto seen = read(grey, fixed_);
    if (!seen) return fail(seen.error());
    if (!seen->saturated) return seen->beat;
    return fail(saturated_spot());
  }

  /// Determines whether the phase rises or falls with the grey level.
  Result<PhaseResponse> find_sign(PhaseResponse rising) {
    const std::array tables{linearising_lut(rising.phase_rad).lut,
                            linearising_lut(negative(rising.phase_rad)).lut};
    std::array<double, 4> seen_dn{};
    for (std::size_t k = 0; k < seen_dn.size(); ++k) {
      const auto light = blazed_dn(tables[k % 2]);
      if (!light) return fail(light.error());
      seen_dn[k] = *light;
    }
    return with_sign(std::move(rising), {seen_dn[0], seen_dn[2]}, {seen_dn[1], seen_dn[3]});
  }

 private:
  enum class Fit { saturated, invisible, good };

  /// Tries one patch diameter, relative to a subaperture.
  Result<Fit> try_patches(double relative_diameter) {
    patches_ = fringe_patches(
        now_->sensor, map_, relative_diameter,
        lit_pixels(bench_.camera().settings.pixel_format, now_->optics.wavelength_nm));
    const auto dark = read(0, 0);
    if (!dark) return fail(dark.error());
    double most = 0.0;
    for (const int grey : kTrials) {
      const auto seen = read(grey, grey);
      if (!seen) return fail(seen.error());
      if (seen->saturated) return Fit::saturated;
      if (seen->brightest_dn <= most) continue;
      most = seen->brightest_dn;
      fixed_ = grey;
    }
    const bool stands_out = most > kMinContrast * std::max(1.0, dark->brightest_dn);
    return stands_out ? Fit::good : Fit::invisible;
  }

  /// Tries the patch diameters. Small patches that do not stand out, where larger ones saturate,
  /// mean too long an exposure.
  Result<Fit> try_exposure() {
    for (const double diameter : kRelativeDiameters) {
      const auto fit = try_patches(diameter);
      if (!fit) return fit;
      if (*fit == Fit::good) return fit;
      if (*fit == Fit::invisible && diameter == kRelativeDiameters.front()) return fit;
    }
    return Fit::saturated;
  }

  // The painter captures by value: after a cancel it may be called when `read` has returned.
  Painter fringes(int grey, int fixed) const {
    return [patches = patches_, sensor = now_->sensor, slm = slm_, grey, fixed](
               const HologramRenderer&, Image<std::uint8_t>& picture) {
      draw_fringe_patches(patches, sensor, slm, grey, fixed, picture);
    };
  }

  Result<Image<float>> picture(const Painter& paint) {
    if (auto shown = bench_.show(paint); !shown) return fail(shown.error());
    return bench_.picture(frames_);
  }

  Result<FringeReading> read(const Painter& paint) {
    const auto light = picture(paint);
    if (!light) return fail(light.error());
    return read_fringe(*light, patches_, base_spot_px(now_->optics, light->width, light->height),
                       map_);
  }

  Result<FringeReading> read(int grey, int fixed) { return read(fringes(grey, fixed)); }

  Result<double> blazed_dn(const PhaseLut& lut) {
    const auto seen = read([patches = patches_, sensor = now_->sensor, slm = slm_, lut](
                               const HologramRenderer&, Image<std::uint8_t>& picture) {
      draw_blazed_patch(patches, sensor, slm, lut, picture);
    });
    if (!seen) return fail(seen.error());
    if (!seen->saturated) return seen->brightest_dn;
    return fail(saturated_spot());
  }

  Bench& bench_;
  SlmGeometry slm_;
  int frames_;
  SensorView now_;
  PxPerCycle map_;
  FringePatches patches_;
  int fixed_ = 0;
};

/// Measures all grey levels upwards and then downwards; the difference of the two passes shows
/// drift. `from` .. `to`: this sweep's share of the progress.
Result<std::vector<GreyBeat>> sweep(Bench& bench, LutBench& lut_bench,
                                    const std::vector<int>& greys, double from, double to) {
  std::vector<GreyBeat> beats;
  for (const int grey : greys) beats.push_back({grey, {}, {}});
  const std::size_t looks = 2 * beats.size();
  for (std::size_t k = 0; k < looks; ++k) {
    bench.report_progress(from + (to - from) * double(k + 1) / double(looks + 1));
    const bool up = k < beats.size();
    GreyBeat& beat = beats[up ? k : looks - 1 - k];
    const auto seen = lut_bench.beat(beat.grey);
    if (!seen) return fail(seen.error());
    (up ? beat.first : beat.second) = *seen;
  }
  return beats;
}

/// Adaptive sampling: starts with evenly spaced levels and adds levels until neighbouring levels
/// have close phases. Each pass measures all levels again, because drift between passes would bend
/// the curve.
Result<std::vector<GreyBeat>> measure_beats(Bench& bench, LutBench& lut_bench, int levels) {
  std::vector<int> greys;
  for (int k = 0; k < levels; ++k) greys.push_back(int(std::lround(255.0 * k / (levels - 1))));
  for (double from = 0.0;;) {
    const double to = 0.5 * (1.0 + from);  // the number of passes is not known in advance
    auto beats = sweep(bench, lut_bench, greys, from, to);
    if (!beats) return beats;
    const auto between = levels_between(*beats);
    if (!between) return fail(between.error());
    if (between->empty()) return beats;
    greys.insert(greys.end(), between->begin(), between->end());
    std::ranges::sort(greys);
    from = to;
  }
}

}  // namespace

Result<MeasuredLut> measure_lut(Bench& bench, const LutRun& run) {
  LutBench lut_bench(bench, run.frames);
  if (auto chosen = lut_bench.choose(); !chosen) return fail(chosen.error());
  if (auto found = lut_bench.find_direction(); !found) return fail(found.error());
  const auto beats = measure_beats(bench, lut_bench, run.levels);
  if (!beats) return fail(beats.error());
  auto response = phase_response(*beats);
  if (!response) return fail(response.error());
  response = lut_bench.find_sign(std::move(*response));
  if (!response) return fail(response.error());
  MeasuredLut lut;
  lut.t_taken_ns = utc_ns();
  lut.frames = run.frames;
  lut.table = linearising_lut(response->phase_rad);
  lut.response = std::move(*response);
  return lut;
}

}  // namespace ovws
