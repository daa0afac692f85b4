#include "daemon/ovwsd/procedures/experiment_run.hpp"

#include "core/port/clock.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"

namespace ovws {

ExperimentRun experiment_run(const GainSweepRun& asked, nlohmann::json bench) {
  constexpr std::size_t kNameDigits = 16;
  const std::string all =
      json_text(nlohmann::json{{"request", to_json(asked.sweep)}, {"bench", bench}});
  return {sha256_hex(all).substr(0, kNameDigits), asked.sweep, std::move(bench), utc_ns(),
          asked.anew};
}

}  // namespace ovws
