/// Changes that make an impossible bench possible.
#pragma once

#include "daemon/ovws/design/design.hpp"

namespace ovws::design {

/// The nearest change of each part that suffices alone, or if there is none, of two parts. Each was
/// tried: find_config accepts the changed bench. `limit`: what makes it impossible. Takes up to a
/// second.
std::vector<Change> changes_that_help(const Bench& bench, const Config& base, Limit limit);

}  // namespace ovws::design
