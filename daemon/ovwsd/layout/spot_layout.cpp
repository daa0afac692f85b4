#include "daemon/ovwsd/layout/spot_layout.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "core/optics/sensor_field.hpp"
#include "core/spots/mode_limit.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "core/tracking/spot_kinds.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"

namespace ovws {
namespace {

constexpr double kMaxStray = 0.3;  ///< of the zeroth order's side orders, relative to a spot

bool fits(Vec2 region, const Roi& roi) {
  return region.x <= roi.width && region.y <= roi.height;
}

/// The charge of the largest spots.
int largest_charge(const SpotBench& bench) {
  int largest = 0;
  for (const Subaperture& one : bench.lattice.subapertures) {
    if (std::abs(one.charge) >= std::abs(largest)) largest = one.charge;
  }
  return largest;
}

std::string spot_name(const SpotBench& bench) {
  const auto& spots = bench.lattice.subapertures;
  const int charge = largest_charge(bench);
  const bool differ = std::any_of(spots.begin(), spots.end(), [charge](const Subaperture& one) {
    return std::abs(one.charge) != std::abs(charge);
  });
  if (differ) return fmt::format("spots of charges up to {}", std::abs(charge));
  return charge == 0 ? "bright spots" : fmt::format("vortices of charge {}", charge);
}

/// Number of spots outside the camera's region, and whether the spots inside determine the modes.
struct Visibility {
  int missing = 0;
  bool determined = false;
};

Visibility visibility_of(const SpotBench& bench, const SpotLayout& layout) {
  const double edge_px = spot_geometry(largest_charge(bench)).ring_outer * layout.lambda_d_px;
  Visibility visibility;
  std::vector<SpotFix> found(layout.spots_px.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vec2 at = layout.spots_px[i];
    const bool inside = at.x >= edge_px && at.y >= edge_px &&
                        at.x <= bench.roi.width - 1 - edge_px &&
                        at.y <= bench.roi.height - 1 - edge_px;
    if (!inside) {
      ++visibility.missing;
      continue;
    }
    found[i].x = float(at.x);
    found[i].y = float(at.y);
  }
  if (visibility.missing == 0) return {0, true};
  const ModeOperator modes = slope_operator(bench.lattice, bench.sensor, bench.tracking,
                                            px_per_cycle(bench.optics, bench.slm));
  const Reconstructor reconstructor(modes.slopes, modes.modes_j, layout.spots_px);
  auto scratch = reconstructor.make_scratch();
  std::vector<float> waves(modes.modes_j.size());
  visibility.determined = reconstructor.solve(found, scratch, waves).determined;
  return visibility;
}

/// Noise-free 16-bit image of a far field.
Image<std::uint16_t> exposed(const Image<std::complex<float>>& far) {
  constexpr float kPeakDn = 4000.0F;
  float peak = 0.0F;
  for (const std::complex<float> one : far.pixels) peak = std::max(peak, std::norm(one));
  Image<std::uint16_t> image(far.width, far.height);
  std::transform(
      far.pixels.begin(), far.pixels.end(), image.pixels.begin(),
      [&](std::complex<float> one) { return std::uint16_t(std::norm(one) / peak * kPeakDn); });
  return image;
}

/// Proposes settings at which neighbouring spots have the recommended distance.
std::string wider_spacing(const SpotBench& bench, const SpotLayout& layout) {
  const double factor = recommended_spot_distance(largest_charge(bench)) / layout.nearest;
  if (!bench.sensor.lenslets.empty()) {
    return fmt::format(
        "array.pitch_um and optics.focal_length_mm as the lenslets have them, at "
        "most {:g} mm at this pitch",
        rounded_down(bench.optics.focal_length_mm / factor));
  }
  const int fewer = int(bench.sensor.subapertures_across / std::sqrt(factor));
  const double spacing = rounded_up(bench.sensor.spacing * factor);
  const Vec2 region = region_for(layout, spacing / bench.sensor.spacing);
  std::string ways;
  if (fewer < 3 || fits(region, bench.roi) || !contains_zeroth_order(region, bench)) {
    ways = fmt::format("sensor.spacing to {:g}", spacing);
    if (!fits(region, bench.roi))
      ways += fmt::format(" and camera.roi to at least {:.0f} x {:.0f} px", region.x, region.y);
  }
  if (fewer < 3) return ways;
  return ways + (ways.empty() ? "" : ", or ") +
         fmt::format("sensor.subapertures_across to {}", fewer);
}

/// Proposes a setting at which all spots fit into the present region.
std::string alternative_to_region(const SpotBench& bench, const SpotLayout& layout) {
  const auto share = [&](double fixed_px) {
    const double x = (0.5 * (bench.roi.width - 1) - fixed_px) / layout.reach_px.x;
    const double y = (0.5 * (bench.roi.height - 1) - fixed_px) / layout.reach_px.y;
    return std::min(x, y);
  };
  const double closer = share(layout.margin_px);
  if (!bench.sensor.lenslets.empty()) {
    const double pupil_mm = 1e-3 * bench.sensor.pupil_diameter_px * bench.slm.pitch_um;
    return fmt::format("array.pupil_mm to {:g}", rounded_down(pupil_mm * closer));
  }
  if (closer * layout.nearest >= recommended_spot_distance(largest_charge(bench))) {
    return fmt::format("sensor.spacing to {:g}", rounded_down(bench.sensor.spacing * closer));
  }
  const double whole_x = (layout.reach_px.x + layout.margin_px) / (0.5 * (bench.roi.width - 1));
  const double whole_y = (layout.reach_px.y + layout.margin_px) / (0.5 * (bench.roi.height - 1));
  const double smaller = 1.0 / std::max(whole_x, whole_y);
  return fmt::format("optics.focal_length_mm to {:g}, and use such a lens",
                     rounded_down(bench.optics.focal_length_mm * smaller));
}

/// Number of spots that are nearer to the zeroth order, at this pixel, than `least_px`.
int spots_near(const SpotLayout& layout, Vec2 zeroth, double least_px) {
  return int(std::count_if(layout.spots_px.begin(), layout.spots_px.end(),
                           [&](Vec2 at) { return norm(at - zeroth) < least_px; }));
}

}  // namespace

SpotBench spot_bench(const Config& config, const Lattice& lattice) {
  const CameraSettings& camera = config.camera.settings;
  return {lattice,    config.sensor,      config.tracking, config.optics, config.slm.geometry,
          camera.roi, camera.pixel_format};
}

SpotLayout spot_layout(const SpotBench& bench) {
  SpotLayout layout;
  layout.spots_px = model_spots_px(bench.lattice, bench.sensor, bench.slm, bench.optics,
                                   bench.roi.width, bench.roi.height);
  layout.lambda_d_px = lambda_d_px(bench.optics, bench.slm, bench.sensor);
  layout.margin_px = (spot_geometry(largest_charge(bench)).dark + 0.5) * layout.lambda_d_px;
  const Vec2 base = base_spot_px(bench.optics, bench.roi.width, bench.roi.height);
  const auto& spots = layout.spots_px;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    layout.reach_px.x = std::max(layout.reach_px.x, std::abs(spots[i].x - base.x));
    layout.reach_px.y = std::max(layout.reach_px.y, std::abs(spots[i].y - base.y));
    for (std::size_t k = 0; k < i; ++k) {
      const double px = std::hypot(spots[i].x - spots[k].x, spots[i].y - spots[k].y);
      layout.nearest = std::min(layout.nearest, px / layout.lambda_d_px);
    }
  }
  return layout;
}

Vec2 region_for(const SpotLayout& layout, double factor) {
  const auto side = [&](double reach_px) {
    const double px = 2.0 * (factor * reach_px + layout.margin_px) + 1.0;
    return kRegionStep * std::ceil(px / kRegionStep);
  };
  return {side(layout.reach_px.x), side(layout.reach_px.y)};
}

Vec2 zeroth_order_px(const SpotBench& bench) {
  return px_per_cycle(bench.optics, bench.slm) * base_grating_cpp(bench.sensor, bench.slm);
}

bool contains_zeroth_order(Vec2 region, const SpotBench& bench) {
  const Vec2 away_px = zeroth_order_px(bench);
  return std::abs(away_px.x) < 0.5 * region.x && std::abs(away_px.y) < 0.5 * region.y;
}

Result<void> check_zeroth_order(const SpotBench& bench) {
  if (!bench.sensor.lenslets.empty()) return {};  // lenslets fill the pupil
  const SpotLayout layout = spot_layout(bench);
  const double margin_px = layout.lambda_d_px;
  const double least = min_zeroth_distance(layout.spots_px.size(), largest_charge(bench));
  const Vec2 base = base_spot_px(bench.optics, bench.roi.width, bench.roi.height);
  const Vec2 at = base - zeroth_order_px(bench);
  const auto inside = [margin_px](double place, int side) {
    return place > -margin_px && place < side - 1 + margin_px;
  };
  const double px_per_groove =
      px_per_cycle(bench.optics, bench.slm).scale() / double(bench.slm.width_px);
  const auto grooves = [&](double away_px) { return std::ceil(away_px / px_per_groove); };
  const double away_px = layout.reach_px.x + least * margin_px;
  if (inside(at.x, bench.roi.width) && inside(at.y, bench.roi.height)) {
    return fail(
        Errc::invalid, "camera.roi",
        fmt::format("the SLM's zeroth order, much brighter than the spots, falls at ({:.0f}, "
                    "{:.0f}) px of the region: move or shrink camera.roi so that it is "
                    "outside, or set the first number of sensor.grooves to {:.0f} or more",
                    at.x, at.y, grooves(std::max(base.x + 2.0 * margin_px, away_px))));
  }
  const int near = spots_near(layout, at, least * margin_px);
  if (near == 0) return {};
  return fail(
      Errc::invalid, "sensor.grooves",
      fmt::format("side orders of the SLM's zeroth order, which falls at ({:.0f}, {:.0f}) px "
                  "of the region, lie on {} of {} spots: these are nearer to it than {:.1f} "
                  "lambda/d; set the first number of sensor.grooves to {:.0f} or more",
                  at.x, at.y, near, layout.spots_px.size(), least, grooves(away_px)));
}

double rounded_up(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return unit * std::ceil(value / unit - 1e-9);
}

double rounded_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return unit * std::floor(value / unit + 1e-9);
}

double min_spot_distance(int charge) {
  const int l = std::abs(charge);
  constexpr std::array<double, 4> kByCharge{1.5, 0.93, 1.05, 1.05};
  const double radii = l < int(kByCharge.size()) ? kByCharge[std::size_t(l)] : 1.35;
  return radii * spot_geometry(l).dark;
}

double recommended_spot_distance(int charge) {
  return 1.6 * spot_geometry(std::abs(charge)).dark;
}

double min_zeroth_distance(std::size_t subapertures, int charge) {
  // Peaks of the light between N subapertures: N times the far field of one of them, whose envelope
  // falls as 8 / (pi^4 r^3) relative to a bright spot.
  const double number = double(subapertures);
  const double bright = spot_intensity(0, 0.0);
  const double peak = spot_intensity(charge, spot_geometry(std::abs(charge)).ring) / bright;
  return std::cbrt(8.0 * number * number / (std::pow(std::numbers::pi, 4) * peak * kMaxStray));
}

Result<void> check_spots_apart(const SpotBench& bench) {
  const SpotLayout layout = spot_layout(bench);
  const double minimum = min_spot_distance(largest_charge(bench));
  if (layout.nearest >= minimum) return {};
  return fail(
      Errc::invalid, bench.sensor.lenslets.empty() ? "sensor.spacing" : "optics.focal_length_mm",
      fmt::format(
          "neighbouring spots are {:.2f} lambda/d apart, but the tracker {} separates {} only "
          "from {:.2f} lambda/d on: set {}",
          layout.nearest, tracker_name(bench.tracking.tracker), spot_name(bench), minimum,
          wider_spacing(bench, layout)));
}

Result<void> check_spots_found(const SpotBench& bench) {
  const SpotModel spots{bench.sensor.charge, lambda_d_px(bench.optics, bench.slm, bench.sensor)};
  const auto kinds = SpotKinds::make(bench.tracking, spots, charges_of(bench.lattice));
  if (!kinds) return fail(kinds.error());
  if (bench.sensor.masks.empty() && !*kinds) return {};
  OpticsConfig centred = bench.optics;  // the region may still be moved
  centred.centre_px.reset();
  const Vec2 region = region_for(spot_layout(bench), 1.0);
  auto field = SensorField::make(bench.sensor, bench.slm, centred, int(region.x), int(region.y));
  if (!field) return fail(field.error());
  field->set_outside(false);
  field->propagate({}, {});
  const Image<std::uint16_t> image = exposed(field->far());
  const auto tracker = make_tracker(bench.tracking, spots);
  if (!tracker) return fail(tracker.error());
  const auto places_px =
      model_spots_px(bench.lattice, bench.sensor, bench.slm, centred, image.width, image.height);
  std::vector<SpotFix> found(places_px.size());
  TrackScratch scratch = *kinds ? (*kinds)->make_scratch() : (*tracker)->make_scratch();
  Acquisition(spots, places_px, image.width, image.height, nullptr, std::nullopt, *kinds)
      .acquire(view_of(image, PixelFormat::mono16), **tracker, scratch, found);
  std::size_t near = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vec2 off = Vec2{found[i].x, found[i].y} - places_px[i];
    if (found[i].found() && norm(off) < spots.lambda_d_px) ++near;
  }
  if (near == found.size()) return {};
  const std::string finds =
      fmt::format("the tracker {} finds {} of {} {}", tracker_name(bench.tracking.tracker), near,
                  found.size(), spot_name(bench));
  if (!bench.sensor.masks.empty()) {
    return fail(
        Errc::invalid, "sensor.mask",
        "behind this mask " + finds + ": make the mask weaker, or set another sensor.charge");
  }
  return fail(Errc::invalid,
              bench.sensor.charges.empty() ? "sensor.alternate_charge" : "sensor.charges",
              finds + ": set charges of one size, or 0 and 1, or a larger sensor.spacing");
}

Result<void> check_mode_count(const SpotBench& bench) {
  const TrackingSettings& tracking = bench.tracking;
  if (!tracking.mode_count) return {};
  const ModeOperator positions =
      slope_operator(bench.lattice, bench.sensor, tracking, px_per_cycle(bench.optics, bench.slm));
  const int requested = *tracking.mode_count, by_positions = int(positions.modes_j.size());
  if (requested == by_positions) return {};
  const auto refuse = [](const std::string& reason) {
    return fail(Errc::invalid, "tracking.mode_count", reason);
  };
  const bool by_shapes = tracking.tracker == TrackerKind::fit;
  if (requested < by_positions && (!by_shapes || !bench.sensor.lenslets.empty())) return {};
  if (requested < by_positions || !by_shapes) {
    return refuse(fmt::format("positions of these spots determine {} modes: set null{}",
                              by_positions, by_shapes ? ", or more" : ", or use the tracker fit"));
  }
  OpticsConfig centred = bench.optics;  // the region may still be moved
  centred.centre_px.reset();
  const Vec2 region = region_for(spot_layout(bench), 1.0);
  const ModeBench modes{bench.sensor,
                        bench.slm,
                        centred,
                        int(region.x),
                        int(region.y),
                        tracking.estimates,
                        lit_pixels(bench.format, bench.optics.wavelength_nm)};
  const auto errors = mode_errors(modes, requested);
  if (!errors) return fail(errors.error());
  if (errors->are_determined()) return {};
  const auto most = most_modes(modes, requested - 1);
  if (!most) return fail(most.error());
  return refuse(
      fmt::format("{} {} with {} estimates each determine {} modes (their expected error together "
                  "is {:.4f} wave at 500 electrons in the brightest pixel), not {} ({:.4f} wave)",
                  bench.lattice.subapertures.size(), spot_name(bench), tracking.estimates,
                  most->modes, most->rms_waves, requested, errors->rms_waves));
}

Result<void> check_spots_in_region(const SpotBench& bench) {
  const SpotLayout layout = spot_layout(bench);
  const Visibility visibility = visibility_of(bench, layout);
  if (visibility.determined) return {};
  const std::string what =
      fmt::format("{} of {} spots fall outside the camera's region of {} x {} px",
                  visibility.missing, layout.spots_px.size(), bench.roi.width, bench.roi.height);
  if (bench.optics.centre_px) {
    return fail(
        Errc::invalid, "camera.roi",
        fmt::format("{}: by optics.centre_px or the registration the spots lie around ({:.0f}, "
                    "{:.0f}) px of the region, up to {:.0f} px away in x and {:.0f} px in y; "
                    "move camera.roi so that it contains them, or run registration.run again",
                    what, bench.optics.centre_px->x, bench.optics.centre_px->y,
                    layout.reach_px.x + layout.margin_px, layout.reach_px.y + layout.margin_px));
  }
  const Vec2 region = region_for(layout, 1.0);
  const std::string instead = alternative_to_region(bench, layout);
  if (contains_zeroth_order(region, bench))
    return fail(Errc::invalid, "camera.roi", fmt::format("{}: set {}", what, instead));
  return fail(Errc::invalid, "camera.roi",
              fmt::format("{}: set its width and height to at least {:.0f} x {:.0f} px, or {}",
                          what, region.x, region.y, instead));
}

}  // namespace ovws
