/// Templates from a reference's picture, for the tracker matched: which spots have their own.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

struct OwnTemplates {
  /// By subaperture, null: the model's. Empty: the model's for all.
  std::vector<std::shared_ptr<const TemplateBank>> banks;
  TemplateReport report;
};

/// Those of `reference`, if `tracking` asks for them and its picture holds them. About 20 ms and
/// 1 MB a spot of the default bench; at most 256 MiB: what needs more keeps the model's template.
/// Off the frame path.
OwnTemplates own_templates(const TrackingSettings& tracking, const SpotModel& spots,
                           const Reference* reference);

/// The same, kept until another picture is asked for. One thread at a time.
class TemplateShelf {
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
