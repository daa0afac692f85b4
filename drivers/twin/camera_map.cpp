#include "drivers/twin/camera_map.hpp"

#include <cmath>
#include <numbers>

namespace ovws::twin {
namespace {

/// Unit vector (cos, sin) of an angle, exact at multiples of 90 degrees.
Vec2 direction(double degrees) {
  const double quarters = std::round(degrees / 90.0);
  const double angle = (degrees - 90.0 * quarters) * std::numbers::pi / 180.0;
  Vec2 d{std::cos(angle), std::sin(angle)};
  for (int k = ((int(quarters) % 4) + 4) % 4; k > 0; --k) d = {-d.y, d.x};
  return d;
}

}  // namespace

Vec2 CameraMap::pixel(Vec2 cpp) const {
  const Vec2 u = cpp - base_cpp;
  return centre_px + scale * (u.x * of_x + u.y * of_y);
}

Vec2 CameraMap::frequency(Vec2 px) const {
  const Vec2 p = (1.0 / scale) * (px - centre_px);
  return base_cpp + Vec2{of_x.x * p.x + of_x.y * p.y, of_y.x * p.x + of_y.y * p.y};
}

CameraMap CameraMap::relative_to(Vec2 corner_px) const {
  CameraMap map = *this;
  map.centre_px = centre_px - corner_px;
  return map;
}

bool CameraMap::axis_aligned() const {
  return of_x.x == 0.0 || of_x.y == 0.0;
}

CameraMap camera_map(const CameraGeometry& geometry, Vec2 base, double scale) {
  const Vec2 along = direction(geometry.rotation_deg);
  const double x = geometry.mirror == Mirror::x ? -1.0 : 1.0;
  const double y = geometry.mirror == Mirror::y ? -1.0 : 1.0;
  return {geometry.centre_px, base, scale, x * along, y * Vec2{-along.y, along.x}};
}

CameraMap camera_map(const Config& config, const CameraGeometry& geometry) {
  const SlmGeometry& slm = config.slm.geometry;
  OpticsConfig optics = config.optics;
  optics.magnification = geometry.magnification;
  return camera_map(
      geometry, {config.sensor.grooves[0] / slm.width_px, config.sensor.grooves[1] / slm.height_px},
      camera_px_per_cycle(optics, slm));
}

}  // namespace ovws::twin
