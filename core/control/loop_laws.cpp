#include "core/control/loop_laws.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/control/integrator.hpp"
#include "core/control/predictor.hpp"

namespace ovws {
namespace {

std::optional<double> own_gain(const LoopSettings& settings, int j) {
  const auto own = std::ranges::find(settings.gains, j, &ModeGain::j);
  return own != settings.gains.end() ? std::optional(own->gain) : std::nullopt;
}

}  // namespace

ModalControl::MakeLaw laws_of(const LoopSettings& settings,
                              std::shared_ptr<const LoopModel> model) {
  return [settings, model = std::move(model)](int j, double waves) -> std::unique_ptr<ModeLaw> {
    const auto gain = own_gain(settings, j);
    const ModeModel* const mode = model && !gain ? model->find(j) : nullptr;
    if (mode != nullptr && settings.law == LawName::predictor) {
      return std::make_unique<Predictor>(mode->disturbance, waves);
    }
    const bool optimised = mode != nullptr && settings.law == LawName::optimised;
    return std::make_unique<Integrator>(optimised ? mode->best_gain : gain.value_or(settings.gain),
                                        settings.leak, waves);
  };
}

Result<void> check_model(const LoopSettings& settings, const LoopModel* model,
                         const std::vector<int>& measured) {
  if (settings.law == LawName::integrator) return {};
  if (model == nullptr) {
    return fail(Errc::refused, "law",
                "this law needs a model of the disturbance: run loop.identify first");
  }
  for (const int j : settings.modes.empty() ? measured : settings.modes) {
    if (j == 0 || own_gain(settings, j)) continue;
    const ModeModel* const mode = model->find(j);
    const bool predicts = settings.law == LawName::predictor;
    const bool stable =
        mode != nullptr &&
        (predicts ? mode->predictor : mode->optimised).gain_margin >= LoopModel::kLeastMargin;
    if (stable) continue;
    return fail(Errc::refused, "law",
                (mode != nullptr ? "the gain margin is too small for mode j = "
                                 : "the model does not have mode j = ") +
                    std::to_string(j) +
                    ": run loop.identify again, or give the mode a gain in gains");
  }
  return {};
}

}  // namespace ovws
