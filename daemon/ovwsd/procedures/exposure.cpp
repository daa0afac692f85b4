#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "daemon/ovwsd/procedures/exposure_look.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"

namespace ovws {
namespace {

constexpr int kMaxLooks = 8;
constexpr int kFrames = 3;               // averaged for a look at an unknown brightness ...
constexpr int kFineFrames = 12;          // ... and for the next ones, as many as fit in ...
constexpr double kFineS = 1.0;           // ... this time, because noise misleads at a high gain
constexpr double kClose = 0.05;          // relative deviation from the target that ends the search
constexpr double kAcceptable = 0.1;      // the same after the last look
constexpr double kNearest = 0.25;        // the same where the camera has no nearer setting
constexpr double kMostlyDark = 0.5;      // share of the black level in the brightness: too much
constexpr double kBlindFactor = 10.0;    // change of the exposure where brightness says nothing
constexpr double kMaxRise = 30.0;        // of the exposure from one look to the next
constexpr double kSame = 1.001;          // rounding of exposures
constexpr double kEven = 0.25;           // of full scale: even light is not a black level
constexpr double kSaturatesRise = 1.5;   // rise of the exposure ...
constexpr double kSaturatesLevel = 1.1;  // ... that must raise the brightness by more than this
constexpr double kTop = 0.95;            // of full scale: the most for the brightest spot
constexpr double kTopFactor = 0.5;       // change of the exposure where only that one is saturated

/// Where the tracker finds the spots of all light sources, in the pixels of `plane`. Empty: the SLM
/// does not show the sensor, or no frame was measured.
std::vector<Vec2> found_spots(Bench& bench, const ColourPlane& plane, int frames) {
  if (bench.sensor()->pattern != HologramKind::sensor) return {};
  std::vector<SpotAverage> sources;
  auto of_main = bench.spots(frames, &sources);
  if (!of_main) return {};
  sources.push_back(std::move(*of_main));
  std::vector<Vec2> found;
  for (const SpotAverage& source : sources) {
    for (const Vec2 at : found_positions(source)) {
      if (!std::isfinite(at.x)) continue;
      found.push_back({(at.x - plane.x) / plane.step, (at.y - plane.y) / plane.step});
    }
  }
  return found;
}

Result<ExposureLook> look_at(Bench& bench, bool fine) {
  const SensorView now = bench.sensor();
  const CameraSettings settings = bench.camera().settings;
  const LitPixels lit = lit_pixels(settings.pixel_format, now->optics.wavelength_nm);
  const double most = std::min(double(kFineFrames), kFineS * settings.frame_rate_hz);
  const auto image = bench.picture(fine ? std::max(kFrames, int(most)) : kFrames);
  if (!image) return fail(image.error());
  auto expected = expected_spots(*now, bench.geometry(), lit);
  if (!expected) return fail(expected.error());
  expected->found_px = found_spots(bench, lit.plane, kFrames);
  return judge_exposure(on_plane(*image, lit.plane), *expected, settings);
}

/// Search for the exposure with which most spots reach the target, and no spot is saturated.
class ExposureSearch {
 public:
  ExposureSearch(Bench& bench, const AutoExposure& asked) : bench_(bench), asked_(asked) {}

  Result<AutoExposureReport> run() {
    if (auto limited = limit_exposure(); !limited) return fail(limited.error());
    for (int looks = 1;; ++looks) {
      bench_.report_progress(double(looks - 1) / kMaxLooks);
      const bool fine = previous_ && previous_->lit && !previous_->saturated();
      const auto look = look_at(bench_, fine);
      if (!look) return fail(look.error());
      if (is_within(*look, looks < kMaxLooks ? kClose : kAcceptable)) return report(*look, looks);
      if (looks == kMaxLooks) return fail(unsteady(*look));
      auto changed = change(*look);
      if (!changed) return fail(changed.error());
      if (!*changed) return report(*look, looks);
      previous_ = *look;
    }
  }

 private:
  /// Whether the look's brightness is that of spots. A few lit peaks may be a zeroth order alone,
  /// unless a longer exposure is saturated.
  bool is_of_spots(const ExposureLook& look) const {
    return look.lit && (look.certain || too_long_us_);
  }

  /// Brightness relative to what is wanted: that of most spots, or of the brightest one if it is
  /// nearer to full scale.
  double reached(const ExposureLook& look) const {
    const double top = look.top.value_or(0.0) / (kTop * look.full);
    return std::max(look.fraction() / asked_.target, top);
  }

  bool is_within(const ExposureLook& look, double tolerance) const {
    return !look.saturated() && is_of_spots(look) && std::abs(reached(look) - 1.0) <= tolerance;
  }

  /// Whether the black level, not the spots, makes the image bright.
  static bool is_stray(const ExposureLook& look) {
    return look.dark > kMostlyDark * look.fraction() * look.full;
  }

  /// Whether the camera's nearest setting will do.
  bool is_usable(const ExposureLook& look) const {
    return is_within(look, kNearest) && !is_stray(look);
  }

  /// Factor by which the exposure should change.
  double factor(const ExposureLook& look) const {
    if (look.mostly_saturated()) return 1.0 / kBlindFactor;
    if (!is_of_spots(look)) return kBlindFactor;
    const auto to = [&look](double share, double from_dn) {
      return (share * look.full - look.dark) / (from_dn - look.dark);
    };
    double by = to(asked_.target, look.brightest);
    if (look.top) by = std::min(by, look.saturated() ? kTopFactor : to(kTop, *look.top));
    return std::clamp(by, 1.0 / kBlindFactor, kMaxRise);
  }

  /// The same, between the exposures that were found too long and too short at this gain: stray
  /// light that is brighter than the spots misleads `factor` otherwise to and fro.
  double bracketed(const ExposureLook& look) {
    if (previous_ && !same_gain(previous_->settings, look.settings))
      too_long_us_ = too_short_us_ = {};
    const double now_us = look.settings.exposure_us, by = factor(look);
    (by < 1.0 ? too_long_us_ : too_short_us_) = now_us;
    const auto& other = by < 1.0 ? too_short_us_ : too_long_us_;
    const bool is_beyond = other && (by < 1.0 ? by * now_us <= *other : by * now_us >= *other);
    return is_beyond ? std::sqrt(*other / now_us) : by;
  }

  struct Limit {
    double us;
    const char* field;
    const char* advice;
  };
  /// Longest exposure that may be used, and what to change for a longer one.
  Limit longest(const CameraSettings& now, const CameraLimits& limits) const {
    Limit longest{limits.exposure_us.max, "camera.exposure_us", ""};
    // Cameras lower the frame rate for exposures longer than a frame period.
    if (const double period_us = 1e6 / now.frame_rate_hz; period_us < longest.us) {
      longest = {period_us, "camera.frame_rate_hz", "lower camera.frame_rate_hz, "};
    }
    if (asked_.max_exposure_us && *asked_.max_exposure_us < longest.us) {
      longest = {*asked_.max_exposure_us, "max_exposure_us", "raise max_exposure_us, "};
    }
    return longest;
  }

  /// Shortens an exposure that is longer than the longest that may be used.
  Result<void> limit_exposure() {
    const CameraSnapshot now = bench_.camera();
    if (!now.limits) return fail(disconnected());
    const Limit most = longest(now.settings, *now.limits);
    if (now.settings.exposure_us <= kSame * most.us) return {};
    CameraSet change;
    change.set_clamp(true);
    change.put(&CameraSettings::exposure_us, most.us);
    if (const auto set = bench_.set_camera(change); !set) return fail(set.error());
    return {};
  }

  /// Changes exposure or gain. Returns false if the camera has no setting that is nearer.
  Result<bool> change(const ExposureLook& look) {
    const auto limits = bench_.camera().limits;
    if (!limits) return fail(disconnected());
    if (!look.lit && !look.saturated() && look.fraction() > kEven) return fail(even(look));
    if (auto rises = check_rises(look); !rises) return fail(rises.error());
    const double now_us = look.settings.exposure_us, by = bracketed(look);
    const Limit most = longest(look.settings, *limits);
    const double least_us = std::min(limits->exposure_us.min, most.us);
    const bool is_longest = now_us * kSame >= most.us, is_shortest = now_us <= least_us * kSame;
    if (by > 1.0 && is_longest && is_usable(look)) return false;
    if (by > 1.0 && is_longest) return fail(too_dark(look, most));
    if (by < 1.0 && is_shortest) return lower_gain(look, *limits, by);
    CameraSet change;
    change.set_clamp(true);
    change.put(&CameraSettings::exposure_us, std::clamp(by * now_us, least_us, most.us));
    return apply(change, look);
  }

  Result<bool> lower_gain(const ExposureLook& look, const CameraLimits& limits, double by) {
    CameraSet change;
    change.set_clamp(true);
    if (limits.gain_raw) {  // its unit is the camera's own
      if (look.settings.gain_raw <= limits.gain_raw->min) return at_darkest(look);
      change.put(&CameraSettings::gain_raw, limits.gain_raw->min);
    } else {
      if (look.settings.gain_db <= limits.gain_db.min) return at_darkest(look);
      change.put(&CameraSettings::gain_db,
                 std::max(limits.gain_db.min, look.settings.gain_db + 20.0 * std::log10(by)));
    }
    return apply(change, look);
  }

  Result<bool> at_darkest(const ExposureLook& look) const {
    if (is_usable(look)) return false;
    return fail(too_bright(look));
  }

  Result<bool> apply(const CameraSet& change, const ExposureLook& look) {
    const auto now = bench_.set_camera(change);
    if (!now) return fail(now.error());
    if (now->settings != look.settings) return true;
    if (look.saturated()) return fail(too_bright(look));
    return false;
  }

  /// Fails if the last rise of the exposure did not make the image brighter.
  Result<void> check_rises(const ExposureLook& look) const {
    if (!previous_ || !previous_->certain || !look.certain || previous_->saturated() ||
        look.saturated() || !same_gain(previous_->settings, look.settings) ||
        reached(look) >= 1.0) {
      return {};
    }
    const bool risen = look.settings.exposure_us > kSaturatesRise * previous_->settings.exposure_us;
    const double before = previous_->brightest - previous_->dark;
    if (!risen || look.brightest - look.dark > kSaturatesLevel * before) return {};
    return fail(Errc::refused, "target",
                fmt::format("a longer exposure does not make the image brighter than {:.0f} % of "
                            "full scale: the camera saturates there; raise camera.gain_db, or "
                            "choose a lower target",
                            100.0 * look.fraction()));
  }

  Error too_dark(const ExposureLook& look, const Limit& most) const {
    if (!look.lit) {
      return {Errc::refused, most.field,
              fmt::format(
                  "no light reaches the camera: at the longest exposure of {:g} ms the image shows "
                  "only noise; check that the laser is on and its shutter open, that the camera's "
                  "cover is off, and that a spot appears with slm.show grating",
                  1e-3 * most.us)};
    }
    const double times = (asked_.target * look.full - look.dark) / (look.brightest - look.dark);
    const std::string needed = look.certain && times > 1.0
                                   ? fmt::format("{:.2g} times the light is needed, or {:.0f} dB",
                                                 times, 20.0 * std::log10(times))
                                   : "fewer peaks stand out than the pattern has spots";
    return {Errc::refused, most.field,
            fmt::format("too dark: at the longest exposure of {:g} ms most spots reach only "
                        "{:.0f} % of full scale; {}raise the laser's power or camera.gain_db: {}",
                        1e-3 * most.us, 100.0 * look.fraction(), most.advice, needed)};
  }

  Error too_bright(const ExposureLook& look) const {
    const std::string advice =
        is_stray(look)
            ? fmt::format(
                  "the darkest pixels are at {:.0f} % already: darken the room, or lower "
                  "the camera's black level",
                  100.0 * look.dark / look.full)
            : "lower the laser's power or insert a neutral-density filter";
    return {Errc::refused, "camera.exposure_us",
            fmt::format("too bright: at the shortest exposure of {:g} us and the lowest gain most "
                        "spots reach up to {:.0f} % of full scale and {} pixels are saturated; {}",
                        look.settings.exposure_us, 100.0 * look.fraction(), look.saturated_pixels,
                        advice)};
  }

  static Error disconnected() {
    return {Errc::unavailable, "camera", "the camera was disconnected"};
  }

  static Error even(const ExposureLook& look) {
    return {Errc::refused, "target",
            fmt::format("the image is evenly bright, at {:.0f} % of full scale, and no spot stands "
                        "out: darken the room, or check that the SLM is lit by the laser and in "
                        "focus",
                        100.0 * look.fraction())};
  }

  Error unsteady(const ExposureLook& look) const {
    return {Errc::refused, "target",
            fmt::format("the brightness does not follow the exposure: after {} looks the brightest "
                        "pixels are at {:.0f} % of full scale; check that the laser's power is "
                        "steady and that nothing moves on the bench",
                        kMaxLooks, 100.0 * look.fraction())};
  }

  static AutoExposureReport report(const ExposureLook& look, int looks) {
    return AutoExposureReport{look.settings.exposure_us, look.settings.gain_db,
                              look.settings.gain_raw,    look.fraction(),
                              look.saturated_pixels,     looks};
  }

  Bench& bench_;
  const AutoExposure asked_;
  std::optional<ExposureLook> previous_;
  std::optional<double> too_long_us_, too_short_us_;
};

}  // namespace

Result<AutoExposureReport> find_exposure(Bench& bench, const AutoExposure& asked) {
  return ExposureSearch(bench, asked).run();
}

Result<AutoExposureReport> set_exposure(Bench& bench, const AutoExposure& asked) {
  auto found = find_exposure(bench, asked);
  if (!found) return found;
  if (auto kept = bench.keep_camera(); !kept) return fail(kept.error());
  return found;
}

}  // namespace ovws
