#include "daemon/ovwsd/procedures/probes.hpp"

#include <algorithm>
#include <cmath>

#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr double kFlooded = 0.02;  // saturated share of an image, in which a spot may be lost

bool is_at_rim(const Image<float>& light, Vec2 at, double rim_px) {
  return at.x < rim_px || at.y < rim_px || at.x > light.width - 1.0 - rim_px ||
         at.y > light.height - 1.0 - rim_px;
}

/// True if a pixel near `at` is NaN: saturated pixels are NaN in a mean image.
bool is_saturated(const Image<float>& light, Vec2 at, double reach_px) {
  const int reach = int(std::ceil(reach_px)), cx = int(at.x), cy = int(at.y);
  for (int y = std::max(0, cy - reach); y < std::min(light.height, cy + reach + 1); ++y) {
    for (int x = std::max(0, cx - reach); x < std::min(light.width, cx + reach + 1); ++x) {
      if (std::isnan(light.at(x, y))) return true;
    }
  }
  return false;
}

/// True if more pixels are saturated than of a zeroth order in view.
bool is_flooded(const Image<float>& light) {
  const auto saturated =
      std::ranges::count_if(light.pixels, [](float dn) { return std::isnan(dn); });
  return double(saturated) > kFlooded * double(light.pixels.size());
}

}  // namespace

Result<Image<float>> ProbeBench::light(const Probe& probe) {
  if (!without_) {
    const auto flat = [](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
      renderer.render(HologramKind::flat, {}, grey);
    };
    if (auto shown = bench_.show(flat); !shown) return fail(shown.error());
    auto without = bench_.picture(frames_);
    if (!without) return without;
    without_ = std::move(*without);
  }
  const auto paint = [probe](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
    renderer.render_probe(probe, grey);
  };
  if (auto shown = bench_.show(paint); !shown) return fail(shown.error());
  auto picture = bench_.picture(frames_);
  if (!picture) return picture;
  if (picture->width != without_->width || picture->height != without_->height) {
    return fail(Errc::refused, "camera",
                "the camera's region changed during the job; start it again");
  }
  for (std::size_t k = 0; k < picture->pixels.size(); ++k) {
    picture->pixels[k] -= without_->pixels[k];
  }
  return picture;
}

Result<std::optional<ProbeSpot>> probe_spot(const Image<float>& light, const SpotModel& spots) {
  const auto rough = spot_in(light, spots);
  if (!rough && is_flooded(light)) return fail(saturated_spot());
  if (!rough || is_at_rim(light, *rough, kProbeRim * spots.lambda_d_px)) {
    return std::optional<ProbeSpot>();
  }
  if (is_saturated(light, *rough, spots.lambda_d_px)) {
    return fail(saturated_spot());
  }
  return std::optional(ProbeSpot{*rough, find_probe(light, spots, *rough)});
}

Result<void> can_scan(const SensorSnapshot& now) {
  if (!now.registration) {
    return fail(Errc::refused, "", "no registration is active: call registration.run first");
  }
  if (!now.correction.empty()) {
    return fail(Errc::refused, "", "a correction is active: call correction.clear first");
  }
  return {};
}

}  // namespace ovws
