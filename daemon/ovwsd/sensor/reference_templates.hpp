/// Templates for the tracker `matched`, cut from a reference's mean image.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

struct OwnTemplates {
  /// One for each subaperture; null: use the model's. Empty: use the model's for all.
  std::vector<std::shared_ptr<const TemplateBank>> banks;
  TemplateReport report;
};

/// Makes the templates if `tracking` requests them and the reference has a usable mean image. Takes
/// about 20 ms and 1 MB for each spot of the default bench. If they need more than 256 MiB, all
/// spots use the model's template. Not for the frame path.
OwnTemplates own_templates(const TrackingSettings& tracking, const SpotModel& spots,
                           const Reference* reference);

/// Caches the result of the last own_templates call. One thread at a time.
class TemplateCache {
 public:
  const OwnTemplates& of(const TrackingSettings& tracking, const SpotModel& spots,
                         const Reference* reference);

 private:
  TrackingSettings tracking_;
  SpotModel spots_;
  bool referenced_ = false;
  std::shared_ptr<const ReferencePicture> picture_;
  std::optional<OwnTemplates> made_;
};

}  // namespace ovws
