/// From the daemon's messages to metrics: names `ovws_*`, base units, as Prometheus reads them.
#pragma once

#include <prometheus/metric_family.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace ovws::metrics {

/// What a counter of `status` counts, in a sentence; empty for a name that this program does not
/// know.
std::string_view counter_help(std::string_view counter);

/// `status`: the newest status message; none: no daemon tells any more, so that nothing but
/// `ovws_up 0` is known. `wavefront`: the newest one that still says how things are. A key that is
/// not there, or null, is a metric that is left out.
std::vector<prometheus::MetricFamily> families(const std::optional<nlohmann::json>& status,
                                               const std::optional<nlohmann::json>& wavefront);

}  // namespace ovws::metrics
