#include "drivers/twin/optical_model.hpp"

#include "drivers/twin/array_model.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/sources_model.hpp"

namespace ovws::twin {

std::unique_ptr<OpticalModel> make_optical_model(const Config& config) {
  const auto make = [config]() -> std::unique_ptr<OpticalModel> {
    if (config.modulator == Modulator::fixed) return std::make_unique<ArrayModel>(config);
    return std::make_unique<BenchModel>(config);
  };
  return std::make_unique<SourcesModel>(make, config.truth);
}

}  // namespace ovws::twin
