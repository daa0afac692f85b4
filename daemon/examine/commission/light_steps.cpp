/// Steps that find the light: base spot, zeroth order, region, exposure.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/optics/lattice.hpp"
#include "daemon/examine/commission/drawing.hpp"
#include "daemon/examine/commission/light.hpp"
#include "daemon/examine/commission/step.hpp"
#include "daemon/examine/in_use.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;

constexpr double kRim = 3.0;            ///< lambda/d that a spot keeps from the region's edge
constexpr double kFarFromMiddle = 4.0;  ///< lambda/d that the base spot may be off the middle

// Exposure ----------------------------------------------------------------------------------------

Outcome run_exposure(Bench& bench, Memory& memory) {
  const cli::Parts before = bench.parts({cli::Part::camera});
  const double before_us = before.at(cli::Part::camera).at("exposure_us").get<double>();
  if (!memory.undo) {
    memory.undo = {
        before, {}, fmt::format("The exposure is {:.0f} us again, as before.", before_us)};
  }
  const auto found = expose_spots(bench);
  if (!found) return failed(found.error());
  const json& gain_db = found->at("gain_db");
  return passed(
      fmt::format("Exposure {:.0f} us (it was {:.0f}){}: most spots reach up to {:.0f} % of full "
                  "scale.",
                  found->at("exposure_us").get<double>(), before_us,
                  gain_db.is_null() ? "" : fmt::format(", gain {:.1f} dB", gain_db.get<double>()),
                  100.0 * found->at("brightest").get<double>()));
}

// Base spot ---------------------------------------------------------------------------------------

struct Field {
  bool fits = false;      ///< enough spots are in the camera's region: check_spots_in_region
  double reach_px = 0.0;  ///< from the base spot to the outermost spots, with room
  double lambda_d_px = 0.0;
};

/// How far the sensor's spots spread on the camera around the base spot, by the registration or
/// else the configuration.
Result<Field> field_of(const json& in_use, const json& registration, const Spot& base) {
  auto config = examine::layout_in_use(in_use);
  if (!config) return fail(config.error());
  config->optics.centre_px = Vec2{base.x, base.y};
  examine::use_registration(*config, registration);
  const auto lattice = make_lattice(config->sensor, config->slm.geometry);
  if (!lattice) return fail(lattice.error());
  const SpotBench bench = spot_bench(*config, *lattice);
  const SpotLayout layout = spot_layout(bench);
  Field field{bool(check_spots_in_region(bench)), 0.0, layout.lambda_d_px};
  for (const Vec2 at : layout.spots_px) {
    field.reach_px = std::max(field.reach_px, norm(at - *config->optics.centre_px));
  }
  field.reach_px += kRim * field.lambda_d_px;
  return field;
}

/// The region of this size, or larger if the spots need it, with the spot in its middle as far as
/// the camera's sensor allows. It holds the spots whatever the camera's rotation.
json region_around(const Spot& spot, const Field& field, const json& camera) {
  const json& roi = camera.at("settings").at("roi");
  const json& limits = camera.at("limits");
  json region;
  for (const auto& [place, size, sensor, at] : {std::tuple{"x", "width", "sensor_width", spot.x},
                                                {"y", "height", "sensor_height", spot.y}}) {
    const int sensor_px = limits.at(sensor).get<int>();
    const int needed = int(std::ceil(2.0 * field.reach_px / 32.0)) * 32;
    const int length = std::min(std::max(roi.at(size).get<int>(), needed), sensor_px);
    const int begin = int(std::lround(roi.at(place).get<double>() + at - 0.5 * (length - 1)));
    region[size] = length;
    region[place] = std::clamp(begin / 2 * 2, 0, sensor_px - length);
  }
  return region;
}

/// How far a spot is from the edge of a region, relative to the current region's origin.
double room(const Spot& spot, const json& region, const json& roi) {
  const double x = spot.x + roi.at("x").get<double>() - region.at("x").get<double>();
  const double y = spot.y + roi.at("y").get<double>() - region.at("y").get<double>();
  return std::min({x, y, region.at("width").get<double>() - 1.0 - x,
                   region.at("height").get<double>() - 1.0 - y});
}

Outcome judge_place(const Spot& spot, const Field& field, const json& camera, Outcome outcome) {
  const json& roi = camera.at("settings").at("roi");
  const json region = region_around(spot, field, camera);
  const double present = room(spot, roi, roi), best = room(spot, region, roi);
  const Vec2 off{spot.x - 0.5 * (roi.at("width").get<double>() - 1.0),
                 spot.y - 0.5 * (roi.at("height").get<double>() - 1.0)};
  const bool is_off = norm(off) > kFarFromMiddle * field.lambda_d_px;
  if (field.fits && !is_off) return outcome;
  const bool helps = best > present + 1.0;
  if (helps) {
    outcome.offers.push_back(
        {"roi",
         fmt::format("move the camera's region to ({}, {}), {} x {} pixels",
                     region.at("x").get<int>(), region.at("y").get<int>(),
                     region.at("width").get<int>(), region.at("height").get<int>()),
         {{"camera.set", {{"roi", region}, {"clamp", true}}}}});
  }
  outcome.passed = field.fits;
  outcome.verdict.severity = field.fits ? Severity::note : Severity::bad;
  outcome.verdict.text +=
      field.fits
          ? " It is off the region's middle."
          : fmt::format(" The sensor's spots spread {:.0f} pixels around it, beyond the region.",
                        field.reach_px);
  outcome.verdict.advice =
      helps             ? "Move the region."
      : norm(off) < 1.0 ? fmt::format(
                              "Make camera.roi {:.0f} pixels wide and high, or use a camera "
                              "or a sensor.spacing with which the spots fit.",
                              2.0 * field.reach_px)
                        : fmt::format("Move the camera by ({:.0f}, {:.0f}) pixels.", off.x, off.y);
  return outcome;
}

/// Images of the grating and of a flat SLM, at the exposure for the grating.
struct Views {
  Image<float> grating, flat;
};
Views views(Bench& bench) {
  cli::Borrow kept(bench.settings().daemon, bench.parts(kLight), bench.restoring());
  bench.call("slm.show", {{"pattern", "grating"}});
  if (auto exposed = expose(bench); !exposed) {  // too bright: the shortest one will do for a place
    const json camera = bench.call("camera.get");
    if (brightest(bench.image()) > 0.9F) {
      (void)bench.try_call("camera.set",
                           {{"exposure_us", camera.at("limits").at("exposure_us").at("min")}});
    }
  }
  Image<float> grating = bench.image_of("grating");
  return {std::move(grating), bench.image_of("flat")};
}

Outcome no_spot(const Views& seen, const Memory& memory) {
  auto outcome =
      failed("The base grating makes no spot in the camera's region.",
             "Either the SLM's phase falls with the grey level, which the look-up table "
             "repairs, or the spot is outside the region: move the region or the camera.",
             other_first(memory, "lut", "measure the look-up table first"));
  outcome.picture = grey_of(seen.grating);
  return outcome;
}

Outcome run_spot(Bench& bench, Memory& memory) {
  const json config = bench.call("config.get");
  const json registration = bench.call("registration.get");
  const json camera = bench.call("camera.get");
  if (!memory.undo) {
    memory.undo = {{},
                   {{"camera.set", {{"roi", camera.at("settings").at("roi")}}}},
                   "The camera's region is as before."};
  }
  bench.say("showing the base grating alone");
  const Views seen = views(bench);
  const auto spot = spot_in(seen.grating, seen.flat);
  if (!spot) return no_spot(seen, memory);
  const auto field = field_of(config, registration, *spot);
  if (!field) return failed(field.error());
  auto outcome =
      passed(fmt::format("The base grating makes one spot, at ({:.0f}, {:.0f}) in "
                         "the region.",
                         spot->x, spot->y));
  const auto zeroth = spot_in(seen.flat, seen.grating);
  outcome.verdict.text +=
      zeroth
          ? fmt::format(" The zeroth order is inside, at ({:.0f}, {:.0f}); it is better outside.",
                        zeroth->x, zeroth->y)
          : " The zeroth order is outside.";
  outcome.picture = grey_of(seen.grating);
  mark(outcome.picture, spot->x, spot->y);
  return judge_place(*spot, *field, camera, std::move(outcome));
}

/// Whether frames are measured, which takes a suitable exposure.
std::optional<bool> has_reference(const Look& look) {
  return done_if(has_measured_reference(look));
}

const std::array kLightSteps{
    Step{
        "spot", "Base spot",
        "Shows the base grating alone, and finds its spot, the zeroth order, and whether all spots "
        "will be inside the camera's region.",
        [](const Look& look) { return done_if(is_true(look, "registration.get", "registered")); },
        run_spot, nullptr, nullptr, false, Needs::holograms},
    Step{"exposure", "Exposure", "Sets the exposure so that the spots are below full scale.",
         has_reference, run_exposure}};

const Step kBrightness{"brightness",
                       "Exposure of the sensor",
                       "Sets the exposure again, for the spots of the corrected sensor.",
                       has_reference,
                       run_exposure,
                       nullptr,
                       nullptr,
                       false,
                       Needs::holograms};

}  // namespace

std::span<const Step> light_steps() {
  return kLightSteps;
}

const Step& brightness_step() {
  return kBrightness;
}

}  // namespace ovws::commission
