/// Further light sources on the camera: each gives the same spots as the main one, elsewhere.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/plan.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "daemon/ovwsd/library/reference.hpp"

namespace ovws {

/// Checks that the spots of all sources lie in regions of their own. A region is the smallest
/// circle about the middle of a source's spots that contains them, wider by half their distance.
/// Errc::invalid, field "beams[k].offset_px": the region of source k overlaps that of the main
/// source or of an earlier one, or too many of its spots fall outside the camera's region.
Result<void> check_beams(const SpotBench& bench, const std::vector<BeamConfig>& beams);

/// The part of the image that is nearest to the spots of each source, as a circle about their
/// middle that no other one's overlaps: the main source's, then in the order of `beams`. Empty
/// without `beams`. `spots_px`: those of the main source.
std::vector<Disc> search_regions(const std::vector<Vec2>& spots_px,
                                 const std::vector<BeamConfig>& beams);

/// The reference of one source; none: `all` has none, or it was taken with another offset.
/// `model_px`: the model's positions of the main source, for a model reference.
std::optional<Reference> reference_of(const Reference& all, const BeamConfig& beam,
                                      const std::vector<Vec2>& model_px);

/// A further source in the active plan.
struct BeamShown {
  std::string name;
  Vec2 offset_px;  ///< mean distance of its expected spots from the main source's
  bool referenced = false;
};
std::vector<BeamShown> beams_of(const MeasurementPlan& plan);

}  // namespace ovws
