/// Searches the number of subapertures across that makes a bench possible, or the changes of the
/// bench that do.
#pragma once

#include "daemon/ovws/design/design.hpp"
#include "proto/limits.hpp"

namespace ovws::design {

/// Subapertures across, unless modes are asked for or they do not work.
constexpr int kUsualAcross = 5;
/// Limits of what is designed. Odd numbers only: with an even one, half a subaperture is left free
/// at the pupil's edge.
constexpr int kLeastAcross = 3;
constexpr int kMostAcross = (limits::kSubaperturesAcross.max - 1) / 2 * 2 + 1;

/// About the largest number of modes that the shapes of the vortices may determine: 2.5 for each,
/// in a lattice with 3/4 of the square of its number across.
constexpr int most_modes_by_shapes(int across) {
  return int(2.5 * 0.75 * across * across);
}

/// Whether modes that positions do not determine may come from the shapes of the spots. With
/// `unused` the search takes milliseconds.
enum class Shapes { unused, used };

/// The configuration with the fewest subapertures that determine the modes, from kUsualAcross on:
/// by the positions of their spots, or with Shapes::used by the shapes. It prefers gratings of at
/// least four SLM pixels a period. With Shapes::used, fewer than kUsualAcross are the last resort.
/// The error is that of the first attempt whose positions determine the modes.
tl::expected<Config, Finding> find_config(const Bench& bench, const Config& base, Shapes shapes);

/// The nearest change of each part that suffices alone, or if there is none, of two parts. Each was
/// tried: find_config accepts the changed bench. `limit`: what makes it impossible. Takes up to a
/// second.
std::vector<Change> changes_that_help(const Bench& bench, const Config& base, Limit limit);

}  // namespace ovws::design
