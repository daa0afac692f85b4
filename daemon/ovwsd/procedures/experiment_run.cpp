#include "daemon/ovwsd/procedures/experiment_run.hpp"

#include "core/port/clock.hpp"
#include "daemon/shared/encoding.hpp"

namespace ovws {

ExperimentRun experiment_run(const GainSweep& request, nlohmann::json bench) {
  constexpr std::size_t kNameDigits = 16;
  const std::string all = nlohmann::json{{"request", to_json(request)}, {"bench", bench}}.dump();
  return {sha256_hex(all).substr(0, kNameDigits), request, std::move(bench), utc_ns()};
}

}  // namespace ovws
