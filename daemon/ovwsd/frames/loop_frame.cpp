#include "daemon/ovwsd/frames/loop_frame.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {

bool copy_to(LoopFrame& frame, const FrameRecord& record) {
  const MeasurementPlan& plan = *record.plan;
  if (plan.hologram_id != record.hologram_id) return false;
  frame.frame_id = record.frame.frame_id;
  frame.hologram_id = record.hologram_id;
  frame.t_end_ns = record.t_exposed_mono_ns;
  frame.t_begin_ns = frame.t_end_ns - std::llround(1e3 * record.exposure_us);
  frame.transfer_ns = record.transfer_ns;
  frame.period_ns = record.period_ns;
  // Spot positions, unlike templates, measure only the leading modes of the plan.
  const auto& modes_j = record.templates.credible ? plan.modes_j : plan.reconstructor->modes_j();
  frame.mode_count = int(modes_j.size());
  std::ranges::copy(modes_j, frame.modes_j.begin());
  std::copy_n(record.coefficients.begin(), frame.mode_count, frame.waves.begin());
  std::copy_n(record.sigma_waves.begin(), frame.mode_count, frame.sigma_waves.begin());
  frame.correction_count = int(plan.correction.size());
  std::copy_n(plan.correction.begin(), frame.correction_count, frame.correction.begin());
  return true;
}

}  // namespace ovws
