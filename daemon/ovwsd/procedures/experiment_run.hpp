/// A gain sweep on a bench.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/tables/experiment.hpp"

namespace ovws {

struct ExperimentRun {
  std::string name;  ///< 16 hexadecimal digits: the same for the same sweep on the same bench
  GainSweep request;
  nlohmann::json bench;  ///< what its numbers are of, and the same while it lasts
  std::int64_t t_begun_ns = 0;
  bool anew = false;  ///< cells that are known already are measured again
};
/// It begins now.
ExperimentRun experiment_run(const GainSweepRun& asked, nlohmann::json bench);

}  // namespace ovws
