#include "core/control/integrator.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {

Integrator::Integrator(LoopSettings settings, std::vector<Mode> correction, std::int64_t now_ns)
    : settings_(std::move(settings)), correction_(std::move(correction)), t_last_ns_(now_ns) {}

bool Integrator::is_corrected(int j) const {
  const auto& modes = settings_.modes;
  return j > 0 && (modes.empty() || std::find(modes.begin(), modes.end(), j) != modes.end());
}

double Integrator::gain_of(int j) const {
  for (const ModeGain& one : settings_.gains) {
    if (one.j == j) return one.gain;
  }
  return settings_.gain;
}

Mode& Integrator::mode(int j) {
  const auto found = std::find_if(correction_.begin(), correction_.end(),
                                  [j](const Mode& one) { return one.j == j; });
  if (found != correction_.end()) return *found;
  return correction_.emplace_back(Mode{j, 0.0});
}

/// Whether `condition` has held without interruption for `patience_s`.
bool Integrator::lasts(bool condition, std::optional<std::int64_t>& since_ns,
                       std::int64_t now_ns) const {
  if (!condition) {
    since_ns.reset();
    return false;
  }
  if (!since_ns) since_ns = now_ns;
  return 1e-9 * double(now_ns - *since_ns) >= settings_.patience_s;
}

void Integrator::follow_level(std::int64_t now_ns) {
  constexpr double kSlowUp = 10.0;
  if (steps_ == 0) {
    level_waves_ = residual_rms_waves_;
    return;
  }
  const bool up = residual_rms_waves_ > level_waves_;
  const double time_s = (up ? kSlowUp : 1.0) * settings_.patience_s;
  const double part = 1.0 - std::exp(-1e-9 * double(now_ns - t_last_ns_) / time_s);
  level_waves_ += part * (residual_rms_waves_ - level_waves_);
}

LoopEnd Integrator::step(std::span<const int> modes_j, std::span<const float> residual_waves,
                         std::int64_t now_ns) {
  double squares = 0.0;
  bool at_limit = false;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (!is_corrected(modes_j[k])) continue;
    const double residual = double(residual_waves[k]);
    squares += residual * residual;
    double& waves = mode(modes_j[k]).waves;
    const double wanted = (1.0 - settings_.leak) * waves + gain_of(modes_j[k]) * residual;
    waves = std::clamp(wanted, -settings_.limit_waves, settings_.limit_waves);
    at_limit = at_limit || std::abs(wanted) > settings_.limit_waves;
  }
  residual_rms_waves_ = std::sqrt(squares);
  follow_level(now_ns);
  ++steps_;
  t_last_ns_ = now_ns;
  const double grown = std::max(settings_.floor_waves, settings_.growth * level_waves_);
  if (lasts(at_limit, at_limit_since_ns_, now_ns)) return LoopEnd::at_limit;
  if (lasts(residual_rms_waves_ > grown, growing_since_ns_, now_ns)) return LoopEnd::growing;
  return LoopEnd::none;
}

LoopEnd Integrator::wait(std::int64_t now_ns, std::int64_t found_ns) const {
  const double waited_s = 1e-9 * double(now_ns - t_last_ns_);
  const double unfound_s = std::min(waited_s, 1e-9 * double(now_ns - found_ns));
  const bool ends =
      unfound_s >= settings_.patience_s || waited_s >= kMaxPatience * settings_.patience_s;
  return ends ? LoopEnd::too_few_spots : LoopEnd::none;
}

}  // namespace ovws
