#include "daemon/ovwsd/sensor/beams.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ovws {
namespace {

Vec2 middle_of(const std::vector<Vec2>& spots_px) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec2 low{kInfinity, kInfinity}, high{-kInfinity, -kInfinity};
  for (const Vec2 at : spots_px) {
    low = {std::min(low.x, at.x), std::min(low.y, at.y)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y)};
  }
  return 0.5 * (low + high);
}

std::string field_of(std::size_t k) {
  return fmt::format("beams[{}].offset_px", k);
}

/// The source that is nearest to source `k` among the main one and the earlier ones.
struct Nearest {
  std::string name;
  double apart_px = 0.0;
};
Nearest nearest_to(std::size_t k, const std::vector<BeamConfig>& beams) {
  Nearest nearest{"the main source", norm(beams[k].offset_px)};
  for (std::size_t i = 0; i < k; ++i) {
    const double apart_px = norm(beams[k].offset_px - beams[i].offset_px);
    if (apart_px < nearest.apart_px) nearest = {"the source " + beams[i].name, apart_px};
  }
  return nearest;
}

}  // namespace

Result<void> check_beams(const SpotBench& bench, const std::vector<BeamConfig>& beams) {
  if (beams.empty()) return {};
  const SpotLayout layout = spot_layout(bench);
  const Vec2 middle = middle_of(layout.spots_px);
  double radius_px = 0.0;
  for (const Vec2 at : layout.spots_px) radius_px = std::max(radius_px, norm(at - middle));
  const double least_px = 2.0 * radius_px + layout.nearest * layout.lambda_d_px;
  for (std::size_t k = 0; k < beams.size(); ++k) {
    const Nearest nearest = nearest_to(k, beams);
    if (nearest.apart_px < least_px) {
      return fail(
          Errc::invalid, field_of(k),
          fmt::format("the spots of the source {} overlap those of {}, {:.0f} px away: tilt "
                      "the source so that it is at least {:.0f} px away, or set a smaller "
                      "sensor.spacing or sensor.subapertures_across",
                      beams[k].name, nearest.name, nearest.apart_px, std::ceil(least_px)));
    }
    OpticsConfig displaced = bench.optics;
    displaced.centre_px =
        base_spot_px(bench.optics, bench.roi.width, bench.roi.height) + beams[k].offset_px;
    const auto seen = check_spots_in_region({bench.lattice, bench.sensor, bench.tracking, displaced,
                                             bench.slm, bench.roi, bench.format});
    if (seen) continue;
    return fail(Errc::invalid, field_of(k),
                fmt::format("of the source {}, {}", beams[k].name, seen.error().reason));
  }
  return {};
}

std::vector<Disc> search_regions(const std::vector<Vec2>& spots_px,
                                 const std::vector<BeamConfig>& beams) {
  std::vector<Disc> regions;
  if (beams.empty()) return regions;
  const Vec2 middle = middle_of(spots_px);
  regions.push_back({middle, 0.0});
  for (const BeamConfig& beam : beams) regions.push_back({middle + beam.offset_px, 0.0});
  for (Disc& one : regions) {
    one.radius = std::numeric_limits<double>::infinity();
    for (const Disc& other : regions) {
      if (&other != &one) one.radius = std::min(one.radius, 0.5 * norm(one.centre - other.centre));
    }
  }
  return regions;
}

std::optional<Reference> reference_of(const Reference& all, const BeamConfig& beam,
                                      const std::vector<Vec2>& model_px) {
  Reference own = all;
  own.beams.clear();
  own.picture.reset();
  if (all.source == ReferenceSource::model) {
    for (std::size_t i = 0; i < model_px.size(); ++i) {
      own.positions_px[i] = model_px[i] + beam.offset_px;
    }
    return own;
  }
  const auto found = std::find_if(all.beams.begin(), all.beams.end(), [&](const auto& one) {
    return one.beam == beam.name && one.offset_px == beam.offset_px;
  });
  if (found == all.beams.end()) return std::nullopt;
  static_cast<SourceReference&>(own) = static_cast<const SourceReference&>(*found);
  return own;
}

std::vector<BeamShown> beams_of(const MeasurementPlan& plan) {
  std::vector<BeamShown> all;
  const auto count = double(plan.predicted_px.size());
  for (const auto& beam : plan.beams) {
    Vec2 offset;
    for (std::size_t i = 0; i < plan.predicted_px.size(); ++i) {
      offset = offset + (1.0 / count) * (beam->predicted_px[i] - plan.predicted_px[i]);
    }
    all.push_back({beam->beam, offset, beam->referenced()});
  }
  return all;
}

}  // namespace ovws
