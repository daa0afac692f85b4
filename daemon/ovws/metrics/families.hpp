/// Converts the daemon's messages to Prometheus metric families: names `ovws_*`, base units.
#pragma once

#include <prometheus/metric_family.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace ovws::metrics {

/// Builds all metrics from the newest messages. Without a current `status`, only `ovws_up 0` is
/// exported. `wavefront`: none if the newest one is too old. A missing or null key in a message
/// omits the metric made from it.
std::vector<prometheus::MetricFamily> families(const std::optional<nlohmann::json>& status,
                                               const std::optional<nlohmann::json>& wavefront);

}  // namespace ovws::metrics
