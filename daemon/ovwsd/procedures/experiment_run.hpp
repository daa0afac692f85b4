/// One run of a gain sweep on a bench.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "proto/tables/experiment.hpp"

namespace ovws {

struct ExperimentRun {
  std::string name;  ///< hash of request and bench, 16 hexadecimal digits
  GainSweep request;
  nlohmann::json bench;  ///< bench settings, see sweep_bench; must not change during the run
  std::int64_t t_begun_ns = 0;
  bool anew = false;  ///< delete earlier results and start over
};
/// A run that begins now.
ExperimentRun experiment_run(const GainSweepRun& asked, nlohmann::json bench);

}  // namespace ovws
