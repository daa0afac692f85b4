#include "daemon/ovwsd/procedures/sweep_frames.hpp"

#include <algorithm>
#include <cmath>

#include "core/wavefront/residual_variance.hpp"

namespace ovws {
namespace {

double median(std::vector<float> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return double(*middle);
}

}  // namespace

std::vector<Vec2> mean_positions(const std::vector<SeriesFrame>& frames) {
  std::vector<Vec2> sums(frames.empty() ? 0 : frames.front().spots.size());
  std::vector<int> found(sums.size(), 0);
  for (const SeriesFrame& frame : frames) {
    for (std::size_t i = 0; i < std::min(sums.size(), frame.spots.size()); ++i) {
      const SpotFix& spot = frame.spots[i];
      if (!spot.found()) continue;
      sums[i] = sums[i] + Vec2{double(spot.x), double(spot.y)};
      ++found[i];
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const bool enough = found[i] > 0 && 2 * std::size_t(found[i]) >= frames.size();
    sums[i] = enough ? (1.0 / found[i]) * sums[i] : Vec2{NAN, NAN};
  }
  return sums;
}

SpotLevels levels_of(const std::vector<SeriesFrame>& frames) {
  std::vector<float> levels, noises;
  SpotLevels all{NAN, NAN, NAN};
  for (const SeriesFrame& frame : frames) {
    for (const SpotFix& spot : frame.spots) {
      all.peak_dn = std::fmax(all.peak_dn, double(spot.peak));
      if (!spot.found()) continue;
      levels.push_back(spot.level);
      if (spot.noise > 0.0F) noises.push_back(spot.noise);
    }
  }
  all.level_dn = median(std::move(levels));
  all.noise_dn = median(std::move(noises));
  return all;
}

std::vector<CellMeasured::Frame> judge_frames(const std::vector<SeriesFrame>& frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced) {
  Reconstructor::Scratch scratch = reconstructor.make_scratch();
  std::vector<float> waves(reconstructor.modes_j().size());
  std::vector<CellMeasured::Frame> judged;
  for (const SeriesFrame& frame : frames) {
    CellMeasured::Frame one;
    one.saturated_fraction = double(frame.saturated_fraction);
    one.tracked = int(std::count_if(frame.spots.begin(), frame.spots.end(),
                                    [](const SpotFix& spot) { return spot.found(); }));
    one.variance_rad2 = NAN;
    if (reconstructor.solve(frame.spots, scratch, waves).determined) {
      one.coefficients.assign(waves.begin(), waves.end());
      one.variance_rad2 = residual_variance_rad2<float>(reconstructor.modes_j(), waves, introduced);
    }
    judged.push_back(std::move(one));
  }
  return judged;
}

}  // namespace ovws
