#include "daemon/ovwsd/loop/step_due.hpp"

#include <algorithm>

namespace ovws {

std::int64_t t_due_ns(const StepState& state) {
  const std::int64_t known_ns = state.has_newest ? state.t_observed_ns : state.t_exposed_ns;
  if (state.t_refresh_ns == 0 || state.refresh_ns == 0 || known_ns == StepState::kNever) {
    return known_ns;
  }
  const std::int64_t ready_ns = std::max(known_ns, state.t_observed_ns + state.usual_prepare_ns);
  const std::int64_t since_ns = std::max<std::int64_t>(0, ready_ns - state.t_refresh_ns);
  const std::int64_t refreshes = (since_ns + state.refresh_ns - 1) / state.refresh_ns;
  // Half a refresh at most, or the hologram may be presented at the refresh before. But never less
  // than usual: the next frames would postpone the step again and again.
  const std::int64_t prepare_ns =
      std::max(state.usual_prepare_ns, std::min(state.safe_prepare_ns, state.refresh_ns / 2));
  return state.t_refresh_ns + refreshes * state.refresh_ns - prepare_ns;
}

}  // namespace ovws
