/// Finds the spots of one image without history, as the daemon does after a sudden change.
#pragma once

#include <optional>
#include <vector>

#include "core/spots/point_model.hpp"
#include "core/tracking/acquisition.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Search without history: Acquisition finds the spots' positions. The tracker `fit` then fits all
/// pixels (PointModel), starting at the wavefront from the positions, then at a flat one. Not
/// thread-safe.
class Searcher {
 public:
  /// `measurer` must outlive it.
  Searcher(const Geometry& geometry, const Measurer& measurer);

  /// Finds a fix of each spot. If `fit` finds no wavefront, all spots are lost.
  std::vector<SpotFix> find(const Exposure& exposure, double read_noise_e);

 private:
  std::vector<SpotFix> fitted(const Exposure& exposure, double read_noise_e,
                              const std::vector<SpotFix>& by_positions);

  const Measurer& measurer_;
  Acquisition acquisition_;
  TrackScratch scratch_;
  std::optional<PointModel> model_;
};

}  // namespace ovws::study
