/// A part: some items of a study or of a replay, computed on one machine, in a file of JSON lines.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace ovws {

/// First line of a part. Parts belong together if all but `share` is the same. Nothing in a part
/// depends on the machine that computed it.
struct PartHead {
  std::string part_of;      ///< command: "study NAME" or "replay"
  std::string version;      ///< of the program
  nlohmann::json options;   ///< everything else that the items depend on
  std::uint64_t items = 0;  ///< of all parts together
  std::string share;        ///< "i/N": the items i-1, i-1+N, …; "A:B": the items A to B-1
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PartHead, part_of, version, options, items, share)

/// Each further line. A part has its items in rising order.
struct PartItem {
  std::uint64_t item = 0;
  nlohmann::json result;
};

}  // namespace ovws
