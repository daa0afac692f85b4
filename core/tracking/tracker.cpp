#include "core/tracking/tracker.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "core/base/number_text.hpp"
#include "core/tracking/centroid.hpp"
#include "core/tracking/lg.hpp"
#include "core/tracking/lg_contour.hpp"
#include "core/tracking/plane_tracker.hpp"

namespace ovws {
namespace {

constexpr double kMinKernel = 0.1, kMaxKernel = 2.0;
constexpr double kMinSpotPx = 3.5, kMaxSpotPx = 200.0;
constexpr int kMaxCharge = 8;

bool follows_bright_spot(TrackerKind kind) {
  return kind == TrackerKind::centroid || kind == TrackerKind::thresholded ||
         kind == TrackerKind::weighted;
}

Result<void> check(const TrackingConfig& config, const SpotModel& spots) {
  if (!(config.kernel_radius >= kMinKernel && config.kernel_radius <= kMaxKernel)) {
    return fail(Errc::invalid, "tracking.kernel_radius",
                "must be from 0.1 to 2 in units of lambda/d");
  }
  const int step = spots.lit.plane.step;
  if (!(spots.lambda_d_px >= kMinSpotPx * step && spots.lambda_d_px <= kMaxSpotPx * step)) {
    return fail(
        Errc::invalid, "optics",
        "lambda/d on the camera must be from " + with_decimals(kMinSpotPx * step, 1) + " to " +
            std::to_string(int(kMaxSpotPx) * step) + " pixels for a spot to be tracked" +
            (step > 1 ? " by a colour camera, of which only every second pixel is lit" : "") +
            ": change the optics or the number of subapertures");
  }
  if (spots.charge < -kMaxCharge || spots.charge > kMaxCharge) {
    return fail(Errc::invalid, "sensor.charge", "must be from -8 to 8 to be tracked");
  }
  if (spots.charge != 0 && follows_bright_spot(config.tracker)) {
    return fail(Errc::invalid, "tracking.tracker",
                "'" + std::string(tracker_name(config.tracker)) +
                    "' follows a bright spot and a vortex has none: use fit or lg, or charge 0");
  }
  return {};
}

std::unique_ptr<const SpotTracker> make(const TrackingConfig& config, const SpotModel& spots) {
  const double kernel = lg_kernel_radius(config, spots.charge) * spots.lambda_d_px;
  switch (config.tracker) {
    case TrackerKind::centroid:
      return std::make_unique<CentroidTracker>(spots);
    case TrackerKind::thresholded:
      return std::make_unique<ThresholdedTracker>(spots);
    case TrackerKind::weighted:
      return std::make_unique<WeightedTracker>(spots);
    case TrackerKind::lg_contour:
      return std::make_unique<LgContourTracker>(spots, kernel);
    case TrackerKind::lg:
    case TrackerKind::fit:  // while no templates exist, and far from their operating point
      return std::make_unique<LgTracker>(spots, kernel);
  }
  return nullptr;
}

}  // namespace

Result<std::unique_ptr<const SpotTracker>> make_tracker(const TrackingConfig& config,
                                                        const SpotModel& spots) {
  if (auto ok = check(config, spots); !ok) return fail(ok.error());
  auto tracker = make(config, spots.on_plane());
  if (!tracker) return fail(Errc::invalid, "tracking.tracker", "unknown tracker");
  return on_plane(std::move(tracker), spots);
}

}  // namespace ovws
