/// Spots that the daemon does not find: which they are, and where.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drivers/zmq/client.hpp"

namespace ovws::cli {

/// Longest wait for the first valid frame of a new wavefront while its spots are found, s: its
/// templates are being rendered, which takes longer on a busy machine.
constexpr double kTemplates_s = 60.0;

/// What to look for where spots are lost.
constexpr const char* kLookThere =
    "Look there for a dark part of the beam, the edge of the region, or light of another "
    "diffraction order";

/// In how many settled frames each spot was found.
struct SpotCounts {
  int frames = 0;
  std::vector<int> found;  ///< per subaperture

  /// Counts a message of the stream `spots`; one that is not settled does not count. Begins again
  /// if the number of subapertures has changed.
  void add(const StreamMessage& message);
  /// Numbers of the spots that were found in less than this share of the frames.
  std::vector<int> lost(double share) const;
};

/// Numbers of the spots that a measured reference leaves out, by the result of reference.get.
std::vector<int> lost_in_reference(const nlohmann::json& reference);

/// Spots with their expected places on the camera, such as "9 at (84, 528) px and 3 more".
/// `reference`: the result of reference.get; without positions the places are left out.
std::string placed_spots(const std::vector<int>& spots, const nlohmann::json& reference);

}  // namespace ovws::cli
