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

/// Builds all metrics from the newest messages. Without a current `status`, only `ovws_up 0` is
/// exported. `wavefront`: none if the newest one is too old. A missing or null key in a message
/// omits the metric made from it.
std::vector<prometheus::MetricFamily> families(const std::optional<nlohmann::json>& status,
                                               const std::optional<nlohmann::json>& wavefront);

}  // namespace ovws::metrics
