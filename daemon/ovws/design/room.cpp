#include "daemon/ovws/design/room.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace ovws::design {

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

}  // namespace ovws::design
