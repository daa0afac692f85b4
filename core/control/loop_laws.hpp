/// Makes the control laws of a closed loop from its settings and the model of the disturbance.
#pragma once

#include <memory>
#include <vector>

#include "core/base/result.hpp"
#include "core/control/loop_model.hpp"
#include "core/control/loop_settings.hpp"
#include "core/control/modal_control.hpp"

namespace ovws {

/// The law of each mode: that of the settings, or an integrator for modes with a gain of their own
/// and for modes that `model` lacks. `model` may be null.
ModalControl::MakeLaw laws_of(const LoopSettings& settings, std::shared_ptr<const LoopModel> model);

/// Checks that the model has every mode that the law shall correct and that has no gain of its own,
/// and that the law's gain margin there is at least LoopModel::kLeastMargin. `measured`: the modes
/// that the sensor measures. Errc::refused, field "law".
Result<void> check_model(const LoopSettings& settings, const LoopModel* model,
                         const std::vector<int>& measured);

}  // namespace ovws
