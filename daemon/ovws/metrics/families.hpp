/// Converts the daemon's messages to Prometheus metric families: names `ovws_*`, base units.
#pragma once

#include <prometheus/metric_family.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace ovws::metrics {

/// Help sentence for a counter of `status`; empty for an unknown name.
std::string_view counter_help(std::string_view counter);

/// Builds all metrics. `status`: the newest status message; none: no current status, so that only
/// `ovws_up 0` is exported. `wavefront`: the newest one if it is current. A missing or null key
/// omits its metric.
std::vector<prometheus::MetricFamily> families(const std::optional<nlohmann::json>& status,
                                               const std::optional<nlohmann::json>& wavefront);

}  // namespace ovws::metrics
