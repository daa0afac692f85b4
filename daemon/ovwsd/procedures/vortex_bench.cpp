#include "daemon/ovwsd/procedures/vortex_bench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr double kTarget = 0.4;                     // of full scale, with the axis in the middle
constexpr double kDarkest = 0.15, kLightest = 0.7;  // accepted
constexpr double kDimmer = 0.6;                     // if only axes off the middle are saturated
constexpr double kMinDepth = 0.02;                  // five grey levels
constexpr double kVortexShare = 0.26;               // peak of a vortex, of that of a bright spot
constexpr int kMaxVortexLooks = 12;

Error too_dark() {
  return {Errc::refused, "camera.exposure_us",
          "the vortex is too dark at the longest exposure: raise the frame period, the gain or the "
          "laser's power, and check that the light fills the pupil"};
}

}  // namespace

VortexBench::VortexBench(Bench& bench, const SlmGeometry& slm, const SensorSnapshot& now,
                         int frames, double probe_diameter_px, Vec2 middle_px)
    : bench_(bench),
      frames_(frames),
      base_cpp_(base_grating_cpp(now.sensor, slm)),
      middle_px_(middle_px),
      beam_{px_per_cycle(now.optics, slm), now.sensor.pupil_diameter_px, 1,
            lit_pixels(bench.camera().settings.pixel_format, now.optics.wavelength_nm)} {
  const double ratio = beam_.pupil_diameter_px / probe_diameter_px;
  first_factor_ = 1.0 / (kVortexShare * std::pow(ratio, 4.0));
}

double VortexBench::brightest(const Image<float>& light) const {
  const double reach = kVortexWindow * beam_.lambda_d_px();
  double most = 0.0;
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      if (norm(Vec2{double(x), double(y)} - middle_px_) > reach) continue;
      const double dn = double(light.at(x, y));
      if (std::isnan(dn)) return dn;
      most = std::max(most, dn);
    }
  }
  return most / full_scale_dn(bench_.camera().settings.pixel_format);
}

Result<void> VortexBench::change_brightness(double factor) {
  const double before_us = bench_.camera().settings.exposure_us, depth_before = depth_;
  const double wanted_us = factor * before_us * depth_ * depth_;  // at full depth
  if (const auto set = change_exposure(bench_, wanted_us / before_us); !set) {
    return fail(set.error());
  }
  const double got_us = bench_.camera().settings.exposure_us;
  depth_ = std::min(1.0, std::sqrt(wanted_us / got_us));
  if (depth_ < kMinDepth) return fail(saturated_spot());
  if (got_us == before_us && depth_ == depth_before) {
    return fail(factor < 1.0 ? saturated_spot() : too_dark());
  }
  probes_.emplace(bench_, frames_);
  return {};
}

Result<std::optional<std::vector<VortexImage>>> VortexBench::try_images(Probe probe, double from,
                                                                        double to) {
  const std::vector<Vec2> axes = vortex_axes();
  std::vector<VortexImage> images;
  probe.depth = depth_;
  for (const Vec2 axis : axes) {
    probe.axis_px = 0.5 * beam_.pupil_diameter_px * axis;
    auto light = probes_->light(probe);
    if (!light) return fail(light.error());
    const double fraction = brightest(*light);
    double factor = 1.0;
    if (std::isnan(fraction)) {
      factor = images.empty() ? 1.0 / kExposureStep : kDimmer;
    } else if (images.empty() && (fraction < kDarkest || fraction > kLightest)) {
      factor = std::min(kTarget / std::max(fraction, 1e-3), 4.0 * kExposureStep);
    }
    if (factor != 1.0) {
      if (auto changed = change_brightness(factor); !changed) return fail(changed.error());
      return std::optional<std::vector<VortexImage>>();
    }
    images.push_back({axis, std::move(*light)});
    bench_.report_progress(from + (to - from) * double(images.size()) / double(axes.size()));
  }
  return std::optional(std::move(images));
}

Result<std::vector<VortexImage>> VortexBench::images(const std::vector<Mode>& shown, double from,
                                                     double to) {
  if (first_factor_) {
    if (auto changed = change_brightness(*first_factor_); !changed) return fail(changed.error());
    first_factor_.reset();
  }
  const Probe probe{base_cpp_, beam_.charge, {}, beam_.pupil_diameter_px, shown};
  for (int look = 0; look < kMaxVortexLooks; ++look) {
    auto images = try_images(probe, from, to);
    if (!images) return fail(images.error());
    if (*images) return std::move(**images);
  }
  return fail(Errc::refused, "camera.exposure_us",
              "the brightness of the vortex does not follow the exposure: check that the laser's "
              "power and the camera's settings are constant");
}

}  // namespace ovws
