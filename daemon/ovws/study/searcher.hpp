/// Finds the spots of one image without history, as the daemon does after a sudden change.
#pragma once

#include <optional>
#include <vector>

#include "core/spots/point_model.hpp"
#include "core/tracking/acquisition.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// By positions (Acquisition); with the tracker `fit` also by all pixels (PointModel), from where
/// positions put the wavefront, or else from a flat one. One thread at a time.
class Searcher {
 public:
  /// `measurer` must outlive it.
  Searcher(const Geometry& geometry, const Measurer& measurer);

  /// A fix of each spot; those of a wavefront that `fit` does not find are all lost.
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
