#include "daemon/ovws/design/design.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/tracking/spot_geometry.hpp"
#include "daemon/ovws/design/search.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"

namespace ovws::design {
namespace {

/// How far a spot can move, lambda/d: halfway to its neighbour, and not out of the region.
double range_of(const SpotLayout& layout, const Config& config) {
  const Roi& roi = config.camera.settings.roi;
  const double dark_px = spot_geometry(config.sensor.charge).dark * layout.lambda_d_px;
  const double x_px = 0.5 * (roi.width - 1) - layout.reach_px.x - dark_px;
  const double y_px = 0.5 * (roi.height - 1) - layout.reach_px.y - dark_px;
  return std::min(0.5 * layout.nearest, std::min(x_px, y_px) / layout.lambda_d_px);
}

double finest_of(const Lattice& lattice) {
  double finest = 0.0;
  for (const Subaperture& one : lattice.subapertures) {
    finest = std::max({finest, std::abs(one.frequency_cpp.x), std::abs(one.frequency_cpp.y)});
  }
  return finest;
}

/// A defocus W = a sqrt(3) (2 r^2 - 1) has the slope 4 sqrt(3) a r at radius r; a subaperture is
/// 2/M pupil radii wide, and the outermost has its centre at r = 1 - 1/M.
double defocus_with_slope(double waves, int across) {
  return waves * across * across / (8.0 * std::numbers::sqrt3 * (across - 1));
}

int modes_of_positions(const Config& config, const Lattice& lattice) {
  const ModeOperator positions = slope_operator(lattice, config.sensor, config.tracking,
                                                px_per_cycle(config.optics, config.slm.geometry));
  return int(positions.modes_j.size());
}

Figures figures_of(const Config& config, const Lattice& lattice, const SpotLayout& layout) {
  Figures out;
  const double pitch_mm = 1e-3 * config.slm.geometry.pitch_um;
  out.subapertures = int(lattice.subapertures.size());
  out.modes_by_positions = modes_of_positions(config, lattice);
  out.modes = config.tracking.mode_count.value_or(out.modes_by_positions);
  out.pupil_mm = pitch_mm * config.sensor.pupil_diameter_px;
  out.subaperture_px = lattice.diameter_px;
  out.subaperture_mm = pitch_mm * lattice.diameter_px;
  out.lambda_d_px = layout.lambda_d_px;
  out.neighbours = layout.nearest;
  out.range_waves = range_of(layout, config);
  out.range_defocus_waves = defocus_with_slope(out.range_waves, config.sensor.subapertures_across);
  out.grating_period_px = 1.0 / norm(base_grating_cpp(config.sensor, config.slm.geometry));
  out.finest_period_px = 1.0 / finest_of(lattice);
  const Vec2 away_px = zeroth_order_px(spot_bench(config, lattice));
  const double camera_mm = 1e-3 * config.optics.camera_pitch_um;
  out.zeroth_order_px = {away_px.x, away_px.y};
  out.zeroth_order_mm = {camera_mm * away_px.x, camera_mm * away_px.y};
  return out;
}

/// Whether the second order of the leftmost spot lies beyond the rightmost spot and its margin.
bool second_order_is_outside(const Config& config, const SpotLayout& layout) {
  const double scale = camera_px_per_cycle(config.optics, config.slm.geometry);
  const double base_px = scale * base_grating_cpp(config.sensor, config.slm.geometry).x;
  return base_px - 3.0 * layout.reach_px.x > layout.lambda_d_px;
}

std::vector<Finding> findings_of(const Bench& bench, const Config& config, const Figures& figures,
                                 const SpotLayout& layout) {
  std::vector<Finding> all;
  const auto add = [&all](Limit limit, std::string reason, std::string help) {
    all.push_back({limit, std::move(reason), std::move(help)});
  };
  const int side_px = std::min(bench.slm.width_px, bench.slm.height_px);
  if (config.sensor.pupil_diameter_px < side_px) {
    add(Limit::beam,
        fmt::format("the beam covers {:.0f} of {} SLM pixels", config.sensor.pupil_diameter_px,
                    side_px),
        fmt::format("a beam of {:.4g} mm uses the whole SLM", 1e-3 * side_px * bench.slm.pitch_um));
  }
  if (layout.nearest < 0.98 * target_distance(bench.charge)) {
    add(Limit::neighbours,
        fmt::format("neighbouring spots are {:.2g} lambda/d apart; {:.2g} would leave more room "
                    "for aberrations",
                    layout.nearest, target_distance(bench.charge)),
        "a shorter lens, a larger camera, or fewer modes");
  }
  if (figures.finest_period_px < 1.0 / kComfortableCpp) {
    add(Limit::grating,
        fmt::format(
            "the finest grating has a period of {:.2g} SLM pixels, which many SLMs diffract "
            "weakly",
            figures.finest_period_px),
        "fewer modes, or a wider beam on an SLM with more pixels");
  }
  if (!second_order_is_outside(config, layout)) {
    add(Limit::orders, "second diffraction orders fall among the spots",
        "measure the look-up table: with a correct one they are weak");
  }
  if (constexpr double kLarge = 60.0; figures.lambda_d_px > kLarge) {
    add(Limit::scale,
        fmt::format("lambda/d is {:.0f} px, more than the measurement needs: frames are large and "
                    "slow",
                    figures.lambda_d_px),
        "a shorter lens, or binning");
  }
  if (!bench.modes && config.sensor.subapertures_across < kUsualAcross) {
    add(Limit::modes,
        fmt::format("only {} subapertures: more of them do not work", figures.subapertures),
        "ovws design with --modes 18 says why");
  }
  if (config.tracking.mode_count) {
    add(Limit::modes,
        fmt::format("{} modes need the shapes of the spots; positions determine {}, so frames that "
                    "only positions measure are not valid",
                    figures.modes, figures.modes_by_positions),
        fmt::format("--modes {}, which positions determine", figures.modes_by_positions));
  }
  return all;
}

/// The finding of a refusal. If the bench works with a beam that covers the SLM, the beam limits
/// it.
Finding main_finding(const Bench& bench, const Config& base, Finding finding) {
  Bench covered = bench;
  covered.beam_mm.reset();
  if (pupil_px(bench) >= pupil_px(covered) || !find_config(covered, base, Shapes::unused)) {
    return finding;
  }
  return {Limit::beam,
          fmt::format("the beam covers {:.0f} of {:.0f} SLM pixels: {}", pupil_px(bench),
                      pupil_px(covered), finding.reason),
          finding.help};
}

}  // namespace

tl::expected<Design, Refusal> design(const Bench& bench, const Config& base) {
  auto config = find_config(bench, base, Shapes::used);
  if (!config) {
    return tl::make_unexpected(Refusal{main_finding(bench, base, config.error()),
                                       changes_that_help(bench, base, config.error().limit)});
  }
  const auto lattice = make_lattice(config->sensor, config->slm.geometry);
  const SpotLayout layout = spot_layout(spot_bench(*config, *lattice));
  const Figures figures = figures_of(*config, *lattice, layout);
  auto findings = findings_of(bench, *config, figures, layout);
  return Design{std::move(*config), figures, std::move(findings)};
}

Bench bench_of(const Config& config) {
  const CameraSettings& camera = config.camera.settings;
  Bench bench;
  bench.wavelength_nm = config.optics.wavelength_nm;
  bench.focal_length_mm = config.optics.focal_length_mm;
  bench.magnification = config.optics.magnification;
  bench.slm = config.slm.geometry;
  bench.settle_ms = config.slm.settle_ms;
  bench.sensor_width = camera.roi.width;
  bench.sensor_height = camera.roi.height;
  bench.camera_pitch_um = config.optics.camera_pitch_um;
  bench.pixel_format = camera.pixel_format;
  bench.beam_mm = 1e-3 * config.slm.geometry.pitch_um * config.sensor.pupil_diameter_px;
  return bench;
}

}  // namespace ovws::design
