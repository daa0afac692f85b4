#include "core/tracking/spot_kinds.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/tracking/spot_geometry.hpp"

namespace ovws {

Result<std::shared_ptr<const SpotKinds>> SpotKinds::make(const TrackingConfig& config,
                                                         const SpotModel& like,
                                                         std::span<const int> charges) {
  std::shared_ptr<SpotKinds> made(new SpotKinds);
  for (const int charge : charges) {
    const int size = std::abs(charge);
    auto kind = std::find_if(made->kinds_.begin(), made->kinds_.end(),
                             [size](const Kind& one) { return one.model.charge == size; });
    if (kind == made->kinds_.end()) {
      made->kinds_.push_back({{size, like.lambda_d_px, like.lit}, nullptr});
      kind = made->kinds_.end() - 1;
    }
    ++kind->spots;
    made->of_spots_.push_back(int(kind - made->kinds_.begin()));
  }
  const bool alike = made->count() == 1 && made->model(0).charge == std::abs(like.charge);
  if (charges.empty() || alike) return std::shared_ptr<const SpotKinds>();
  for (Kind& kind : made->kinds_) {
    auto tracker = make_tracker(config, kind.model);
    if (!tracker) return fail(tracker.error());
    kind.tracker = std::move(*tracker);
  }
  for (const int kind : made->of_spots_) {
    const int charge = made->model(kind).charge;
    made->levels_.push_back(
        float(spot_intensity(charge, spot_geometry(charge).ring) / spot_intensity(0, 0.0)));
  }
  return std::shared_ptr<const SpotKinds>(std::move(made));
}

TrackScratch SpotKinds::make_scratch() const {
  TrackScratch most;
  for (const Kind& kind : kinds_) {
    const TrackScratch needed = kind.tracker->make_scratch();
    most.samples.resize(std::max(most.samples.size(), needed.samples.size()));
    most.sums.resize(std::max(most.sums.size(), needed.sums.size()));
  }
  return most;
}

}  // namespace ovws
