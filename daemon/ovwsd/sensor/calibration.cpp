#include "daemon/ovwsd/sensor/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr double kScaleTolerance = 0.002;  // relative to px_per_cycle

bool same_registration(const CalibrationKey& a, const CalibrationKey& b) {
  const PxPerCycle &p = a.px_per_cycle, &q = b.px_per_cycle;
  const double off = std::max(std::hypot(p.xx - q.xx, p.yx - q.yx),  //
                              std::hypot(p.xy - q.xy, p.yy - q.yy));
  if (off > kScaleTolerance * p.scale()) return false;
  // Base spots are compared for equal regions only: without a registration the base spot moves with
  // the region. `differences` reports unequal regions itself.
  return !(a.sensor.roi == b.sensor.roi) ||
         norm(a.base_px - b.base_px) <= kPositionTolerance * a.lambda_d_px;
}

}  // namespace

CalibrationKey calibration_key(const ReferenceKey& sensor, const OpticsConfig& configured,
                               const SlmGeometry& slm,
                               const std::optional<Registration>& registration,
                               nlohmann::json camera) {
  const Roi& roi = sensor.roi;
  OpticsConfig optics = configured;
  Vec2 base_px =
      base_spot_px(configured, roi.width, roi.height) + Vec2{double(roi.x), double(roi.y)};
  if (registration) {
    optics.registered = registration->px_per_cycle;
    base_px = registration->base_px;
  }
  return {sensor,
          px_per_cycle(optics, slm),
          base_px,
          lambda_d_px(optics, slm, sensor.sensor),
          std::move(camera),
          nullptr};
}

ModeOperator mode_operator_of(const MeasuredCalibration& measured) {
  const InteractionMatrix& matrix = measured.matrix;
  return {OperatorKind::measured, matrix.modes_j, matrix.slopes, {}, measured.shapes};
}

std::vector<std::string> differences(const CalibrationKey& a, const CalibrationKey& b) {
  const SensorConfig &s = a.sensor.sensor, &t = b.sensor.sensor;
  const TrackingSettings &u = a.sensor.tracking, &v = b.sensor.tracking;
  const bool other_camera = !a.camera.is_null() && !b.camera.is_null() && a.camera != b.camera;
  const bool other_slm = !a.slm.is_null() && !b.slm.is_null() && a.slm != b.slm;
  const std::initializer_list<std::pair<const char*, bool>> fields{
      {"charge", s.charge != t.charge},
      {"alternate_charge", s.alternate_charge != t.alternate_charge},
      {"charges", s.charges != t.charges},
      {"mask", s.masks != t.masks},
      {"grid", s.grid != t.grid},
      {"subapertures_across", s.subapertures_across != t.subapertures_across},
      {"pupil_diameter_px", s.pupil_diameter_px != t.pupil_diameter_px},
      {"grooves", s.grooves != t.grooves},
      {"spacing", s.spacing != t.spacing},
      {"tracker", u.tracker != v.tracker},
      {"kernel_radius", u.kernel_radius != v.kernel_radius},
      {"mode_count", u.mode_count != v.mode_count},
      {"roi", !(a.sensor.roi == b.sensor.roi)},
      {"registration", !same_registration(a, b)},
      {"camera", other_camera},
      {"slm.lut or slm.flatness", other_slm}};
  std::vector<std::string> names;
  for (const auto& [name, differs] : fields) {
    if (differs) names.emplace_back(name);
  }
  return names;
}

}  // namespace ovws
