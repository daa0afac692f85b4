#include "core/wavefront/relinearise.hpp"

#include <cmath>

#include "core/wavefront/diffractive_matrix.hpp"
#include "core/wavefront/reconstructor.hpp"

namespace ovws {

Result<Relinearised> relinearise(SensorModel& model, const SensorConfig& sensor,
                                 const SpotTracker& tracker, const Eigen::MatrixXd& slopes,
                                 std::span<const int> modes_j, std::span<const SpotFix> fixes,
                                 std::span<const float> start, int steps) {
  Relinearised result;
  result.waves.assign(start.begin(), start.end());
  std::vector<float> correction(modes_j.size());
  std::vector<Mode> modes(modes_j.size());
  for (int k = 0; k < steps; ++k) {
    for (std::size_t m = 0; m < modes.size(); ++m) modes[m] = {modes_j[m], result.waves[m]};
    const auto expected = model_fixes(model, sensor, tracker, modes);
    if (!expected) return fail(expected.error());
    std::vector<Vec2> from;  // NaN, thus lost, where the model has no spot
    for (const SpotFix& fix : *expected) from.push_back({double(fix.x), double(fix.y)});
    const Reconstructor reconstructor(slopes, {modes_j.begin(), modes_j.end()}, std::move(from));
    auto scratch = reconstructor.make_scratch();
    const Reconstruction step = reconstructor.solve(fixes, scratch, correction);
    if (!step.determined) {
      return fail(Errc::refused, "tracking",
                  "too many spots are lost in the image or in the model to determine the modes");
    }
    double squares = 0.0;
    for (std::size_t m = 0; m < modes.size(); ++m) {
      result.waves[m] += double(correction[m]);
      squares += double(correction[m]) * double(correction[m]);
    }
    result.last_step_waves = std::sqrt(squares);
    result.fit_residual_px = step.fit_residual_px;
  }
  return result;
}

}  // namespace ovws
