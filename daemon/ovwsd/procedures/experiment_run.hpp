/// A gain sweep on a bench.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/experiment.hpp"

namespace ovws {

struct ExperimentRun {
  std::string name;  ///< 16 hexadecimal digits: the same for the same sweep on the same bench
  GainSweep request;
  nlohmann::json bench;  ///< what its numbers are of, and the same while it lasts
  std::int64_t t_begun_ns = 0;
};
/// It begins now.
ExperimentRun experiment_run(const GainSweep& request, nlohmann::json bench);

}  // namespace ovws
