#include "daemon/ovwsd/fitter/search_policy.hpp"

#include <algorithm>

namespace ovws {
namespace {

constexpr double kDriftWaves = 0.02;   // acceptable drift where the fit leaves only noise
constexpr double kBentWaves = 0.002;   // acceptable drift where it leaves more
constexpr double kDriftSigmas = 3.0;   // drift by chance, standard errors
constexpr double kMaxResidual = 1.5;   // residual by chance, standard errors
constexpr double kMoreResidual = 1.3;  // largest residual relative to point_residual
constexpr double kCalmResidual = 0.7;  // relative to point_residual: below, the air has calmed
constexpr double kFarInAirWaves = 0.05;

}  // namespace

bool is_drifted(const TemplateDrift& frame) {
  const bool is_bent =
      frame.residual > std::max(kMaxResidual, kMoreResidual * frame.point_residual);
  const double limit =
      std::max(is_bent ? kBentWaves : kDriftWaves, kDriftSigmas * frame.sigma_waves);
  if (!frame.in_air) return frame.drift_waves > limit;
  const bool has_calmed = frame.residual < kCalmResidual * frame.point_residual;
  return is_bent || has_calmed || frame.drift_waves > std::min(limit, kFarInAirWaves);
}

bool SearchPolicy::is_due(Doubt doubt, bool changed, std::int64_t now_ns) const {
  if (doubt == Doubt::none) return false;
  if (tries_ == 0) return true;
  if (doubt == Doubt::partial && now_ns < ended_ns_ + kCalmPauseNs) return false;
  return changed || now_ns >= next_ns_;
}

void SearchPolicy::begin(bool changed) {
  if (!changed) return;
  tries_ = 0;
  pause_ns_ = kFirstPauseNs;
}

void SearchPolicy::end(std::int64_t now_ns) {
  ++tries_;
  ended_ns_ = now_ns;
  next_ns_ = now_ns + pause_ns_;
  pause_ns_ = std::min(2 * pause_ns_, kMaxPauseNs);
}

bool GivingUp::failed(bool given_up, std::int64_t began_ns, std::int64_t now_ns, int frames,
                      int explained) {
  if (failing_since_ns_ == 0) failing_since_ns_ = began_ns;
  if (given_up) return 4 * explained >= frames;
  return now_ns - failing_since_ns_ > kAfterNs && 2 * explained > frames;
}

}  // namespace ovws
