#include "daemon/ovws/design/search.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/tracking/spot_geometry.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "proto/limits.hpp"

namespace ovws::design {
namespace {

/// The largest distance of neighbouring spots, lambda/d, that each limit allows.
struct Room {
  double by_region = 0.0;
  double by_grating = 0.0;  ///< if the zeroth order need not be outside the region
  double by_orders = 0.0;   ///< with the zeroth order outside the region
};

/// Lengths of a candidate in cycles per SLM pixel.
struct Cycles {
  Vec2 reach_per_distance;  ///< of the farthest spot, for a distance of neighbours of 1 lambda/d
  double lambda_d = 0.0;
  double margin = 0.0;
  double to_zeroth = 0.0;  ///< from the farthest spot to the zeroth order, at least

  explicit Cycles(const Candidate& of)
      : reach_per_distance((1.0 / of.px_per_cycle / of.unit.nearest) * of.unit.reach_px),
        lambda_d(of.unit.lambda_d_px / of.px_per_cycle),
        margin(of.unit.margin_px / of.px_per_cycle),
        to_zeroth(
            std::max(margin + lambda_d + 0.5 * kRegionStep / of.px_per_cycle,
                     lambda_d * min_zeroth_distance(of.unit.spots_px.size(), of.bench.charge))) {}
  Vec2 reach(double distance) const { return distance * reach_per_distance; }
  /// Slope of an aberration that moves a spot halfway to its neighbour.
  double headroom(double distance) const { return 0.5 * distance * lambda_d; }
};

/// How much room region, gratings and zeroth order leave. `finest_cpp`: limit of the gratings.
Room room_of(const Candidate& of, double finest_cpp) {
  const Roi& roi = of.config.camera.settings.roi;
  const auto fits = [&of](int side_px, double reach_px) {
    return of.unit.nearest * (0.5 * (side_px - 1) - of.unit.margin_px) / reach_px;
  };
  const Cycles in(of);
  const Vec2 grows = in.reach_per_distance;
  const double headroom = in.headroom(1.0);
  Room room;
  room.by_region =
      std::min(fits(roi.width, of.unit.reach_px.x), fits(roi.height, of.unit.reach_px.y));
  room.by_grating = finest_cpp / (std::max(grows.x, grows.y) + headroom);
  room.by_orders =
      std::min(room.by_grating, (finest_cpp - in.to_zeroth) / (2.0 * grows.x + headroom));
  return room;
}

/// What it means that neighbouring spots cannot have the recommended distance.
Finding too_little_room(const Candidate& of, const Room& room) {
  const int charge = of.bench.charge;
  const double wanted = recommended_spot_distance(charge);
  const Roi& roi = of.config.camera.settings.roi;
  if (room.by_region <= room.by_orders) {
    const Vec2 region = region_for(of.unit, wanted / of.unit.nearest);
    const std::string need = fmt::format(
        "{} spots of lambda/d = {:.3g} px need {:.0f} x {:.0f} px, but the sensor has {} x {}",
        of.unit.spots_px.size(), of.unit.lambda_d_px, region.x, region.y, of.bench.sensor_width,
        of.bench.sensor_height);
    if (room.by_region < min_spot_distance(charge)) return {Limit::region, need, ""};
    return {
        Limit::neighbours,
        fmt::format("{}: within {} x {} px neighbours would be {:.2g} lambda/d apart, and {:.2g} "
                    "is the least that leaves room for aberrations",
                    need, roi.width, roi.height, room.by_region, wanted),
        ""};
  }
  const double d_px = of.config.sensor.pupil_diameter_px / of.config.sensor.subapertures_across;
  if (room.by_grating < wanted) {
    return {Limit::grating,
            fmt::format("subapertures of {:.3g} SLM pixels are too small: the gratings that "
                        "separate {} spots, and aberrations, exceed half a cycle per SLM pixel",
                        d_px, of.unit.spots_px.size()),
            ""};
  }
  return {Limit::orders,
          fmt::format(
              "subapertures of {:.3g} SLM pixels are too small: the base grating that moves "
              "{} spots {:.2g} lambda/d away from the zeroth order, whose side orders are "
              "brighter than they, would exceed half a cycle per SLM pixel",
              d_px, of.unit.spots_px.size(), min_zeroth_distance(of.unit.spots_px.size(), charge)),
          ""};
}

int whole_steps(double px) {
  return kRegionStep * int(std::floor(px / kRegionStep));
}

/// The limit that an error of the configuration's checks is about.
Finding finding_of(const Error& error, const Config& config) {
  const double lambda_d = lambda_d_px(config.optics, config.slm.geometry, config.sensor);
  const auto about = [&error](const char* field) { return error.field == field; };
  if (about("optics")) {
    return {Limit::scale, fmt::format("lambda/d is {:.3g} px: {}", lambda_d, error.reason), ""};
  }
  if (about("sensor.spacing")) return {Limit::neighbours, error.reason, ""};
  if (about("camera.roi")) return {Limit::region, error.reason, ""};
  if (about("sensor.grooves")) return {Limit::grating, error.reason, ""};
  if (about("sensor.pupil_diameter_px")) return {Limit::beam, error.reason, ""};
  return {Limit::modes, text_of(error), ""};
}

Config bare_config(const Bench& bench, const Config& base, int across) {
  Config config = base;
  config.slm.geometry = bench.slm;
  config.slm.settle_ms = bench.settle_ms;
  config.camera.settings.pixel_format = bench.pixel_format;
  config.camera.settings.roi = {0, 0, whole_steps(bench.sensor_width),
                                whole_steps(bench.sensor_height)};
  config.optics = {bench.wavelength_nm, bench.focal_length_mm, bench.magnification,
                   bench.camera_pitch_um, std::nullopt};
  config.sensor.charge = bench.charge;
  config.sensor.alternate_charge.reset();
  config.sensor.charges.clear();
  std::erase_if(config.sensor.masks,
                [](const MaskConfig& mask) { return !mask.subapertures.empty(); });
  config.sensor.subapertures_across = across;
  config.sensor.pupil_diameter_px = pupil_px(bench);
  config.sensor.grooves = {0.0, 0.0};
  // Half the Nyquist limit at the pupil's edge; distances are proportional to the spacing.
  const int side = std::min(bench.slm.width_px, bench.slm.height_px);
  config.sensor.spacing = 0.5 * side / config.sensor.pupil_diameter_px;
  config.tracking.mode_count.reset();
  return config;
}

double rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return unit * std::round(value / unit);
}

/// Sets the base grating: far enough from the zeroth order, and if the gratings may be that fine,
/// far enough that no second order falls among the spots.
void set_grooves(Config& config, const Candidate& of, double distance, double finest_cpp) {
  const Cycles in(of);
  const Vec2 reach = in.reach(distance);
  const double least = reach.x + in.to_zeroth;
  const double most = finest_cpp - reach.x - in.headroom(distance);
  const bool comfortable = finest_cpp <= kComfortableCpp;
  const double x =
      comfortable ? std::clamp(3.0 * reach.x + in.margin, least, std::max(least, most)) : least;
  // A little in y moves the spots off the axes, where edges of pixels and of the beam scatter.
  const double y = std::min(x / 6.0, std::max(0.0, kNyquistCpp - reach.y - in.headroom(distance)));
  config.sensor.grooves = {std::ceil(x * of.bench.slm.width_px),
                           std::floor(y * of.bench.slm.height_px)};
}

/// Sets a region in the sensor's middle with room for spots to move halfway to their neighbours,
/// as far as sensor and zeroth order allow.
void set_region(Config& config, const Candidate& of, double distance) {
  const double move_px =
      (spot_geometry(of.bench.charge).dark + 0.5 * distance) * of.unit.lambda_d_px;
  const Vec2 reach_px = (distance / of.unit.nearest) * of.unit.reach_px;
  const double away_px = of.px_per_cycle * config.sensor.grooves[0] / of.bench.slm.width_px;
  const auto side = [&](double reach, int most) {
    return std::min(whole_steps(2.0 * (reach + move_px) + kRegionStep), most);
  };
  Roi& roi = config.camera.settings.roi;
  const int before_zeroth = whole_steps(2.0 * (away_px - of.unit.lambda_d_px));
  roi.width = side(reach_px.x, std::min(roi.width, before_zeroth));
  roi.height = side(reach_px.y, roi.height);
  roi.x = whole_steps(0.5 * (of.bench.sensor_width - roi.width));
  roi.y = whole_steps(0.5 * (of.bench.sensor_height - roi.height));
}

/// Modes that are wanted and not determined; none: there are enough.
std::optional<Finding> too_few_modes(const Bench& bench, const Config& config) {
  if (!bench.modes || config.tracking.mode_count) return std::nullopt;
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  const ModeOperator positions = slope_operator(*lattice, config.sensor, config.tracking,
                                                px_per_cycle(config.optics, config.slm.geometry));
  const int determined = int(positions.modes_j.size());
  if (determined >= *bench.modes) return std::nullopt;
  return Finding{Limit::modes,
                 fmt::format("{} subapertures determine {} modes only",
                             lattice->subapertures.size(), determined),
                 ""};
}

}  // namespace

double pupil_px(const Bench& bench) {
  const double side = std::min(bench.slm.width_px, bench.slm.height_px);
  if (!bench.beam_mm) return side;
  return std::min(side, std::floor(*bench.beam_mm * 1e3 / bench.slm.pitch_um));
}

Candidate make_candidate(const Bench& bench, const Config& base, int across, bool shapes) {
  Candidate made{bench, bare_config(bench, base, across), {}, 0.0, std::nullopt};
  Config& config = made.config;
  if (shapes) {
    config.tracking.tracker = TrackerKind::fit;
    config.tracking.mode_count = bench.modes;
  }
  if (!(config.sensor.pupil_diameter_px >= limits::kPupilDiameterPx.min)) {
    made.fault = Finding{
        Limit::beam,
        fmt::format("the beam covers {:.0f} SLM pixels only", config.sensor.pupil_diameter_px), ""};
    return made;
  }
  if (auto usable = check_sensor(config); !usable) {
    made.fault = finding_of(usable.error(), config);
    return made;
  }
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  made.unit = spot_layout(spot_bench(config, *lattice));
  made.px_per_cycle = camera_px_per_cycle(config.optics, config.slm.geometry);
  return made;
}

tl::expected<Config, Finding> attempt(const Candidate& candidate, double finest_cpp) {
  if (candidate.fault) return tl::make_unexpected(*candidate.fault);
  const Room room = room_of(candidate, finest_cpp);
  const int charge = candidate.bench.charge;
  const double distance = std::min({target_distance(charge), room.by_region, room.by_orders});
  // The spacing is rounded to four digits; a distance at the limit is not refused for that.
  if (distance < 0.999 * recommended_spot_distance(charge)) {
    return tl::make_unexpected(too_little_room(candidate, room));
  }
  Config config = candidate.config;
  config.sensor.spacing = rounded(config.sensor.spacing * distance / candidate.unit.nearest);
  set_grooves(config, candidate, distance, finest_cpp);
  set_region(config, candidate, distance);
  if (auto usable = check_sensor(config); !usable) {
    return tl::make_unexpected(finding_of(usable.error(), config));
  }
  if (auto seen = check_sees_spots(config); !seen) {
    return tl::make_unexpected(finding_of(seen.error(), config));
  }
  if (auto few = too_few_modes(candidate.bench, config)) return tl::make_unexpected(*few);
  return config;
}

}  // namespace ovws::design
