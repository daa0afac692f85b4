#include "daemon/shared/loop_model_json.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "proto/tables/loop.hpp"

namespace ovws {
namespace {

Result<ModeModel> mode_from(const nlohmann::json& from) {
  ModeModel mode;
  mode.j = from.at("j").get<int>();
  mode.best_gain = from.at("best_gain").get<double>();
  mode.disturbance.noise_waves = from.at("noise_waves").get<double>();
  for (const auto& one : from.at("parts")) {
    const auto part = decode<Oscillator>(one);
    if (!part) return fail(part.error());
    mode.disturbance.parts.push_back(*part);
  }
  if (mode.disturbance.parts.size() > std::size_t(Disturbance::kMaxParts)) {
    return fail(Errc::invalid, "modes", "a mode has too many parts");
  }
  return mode;
}

}  // namespace

Result<LoopModel> loop_model_from(const nlohmann::json& modes) {
  LoopModel model;
  try {
    for (const auto& from : modes) {
      auto mode = mode_from(from);
      if (!mode) return fail(mode.error());
      model.modes.push_back(std::move(*mode));
    }
  } catch (const nlohmann::json::exception& wrong) {
    return fail(Errc::invalid, "modes", wrong.what());
  }
  return model;
}

}  // namespace ovws
