/// Searches the number of subapertures across that makes a bench possible.
#pragma once

#include "daemon/ovws/design/design.hpp"

namespace ovws::design {

/// Subapertures across, unless modes are asked for or they do not work.
constexpr int kUsualAcross = 5;

/// Whether modes that positions do not determine may come from the shapes of the spots. With
/// `unused` the search takes milliseconds.
enum class Shapes { unused, used };

/// The configuration with the fewest subapertures whose positions determine the modes. It prefers
/// gratings of at least four SLM pixels a period. If there is none, and with Shapes::used, it takes
/// fewer subapertures whose shapes determine the modes. The error is that of the first attempt.
tl::expected<Config, Finding> find_config(const Bench& bench, const Config& base, Shapes shapes);

}  // namespace ovws::design
