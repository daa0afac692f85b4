#include "core/control/modal_control.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws {
namespace {

template <class Modes>
double waves_of(const Modes& modes, int j) {
  double sum = 0.0;
  for (const auto& mode : modes) sum += mode.j == j ? mode.waves : 0.0;
  return sum;
}

}  // namespace

ModalControl::ModalControl(LoopSettings settings, std::vector<Mode> correction, MakeLaw make_law)
    : settings_(std::move(settings)),
      correction_(std::move(correction)),
      make_law_(std::move(make_law)) {}

bool ModalControl::is_corrected(int j) const {
  const auto& modes = settings_.modes;
  return j > 0 && (modes.empty() || std::find(modes.begin(), modes.end(), j) != modes.end());
}

ModalControl::Law& ModalControl::law_of(int j) {
  Law& one = laws_[j];
  if (!one.law) one.law = make_law_(j, waves_of(correction_, j));
  return one;
}

void ModalControl::observe(const LoopSample& sample, std::span<const Mode> shown) {
  double squares = 0.0;
  for (auto& known : laws_) known.second.observed = false;
  for (std::size_t k = 0; k < sample.modes_j.size(); ++k) {
    const int j = sample.modes_j[k];
    const double residual = double(sample.residual_waves[k]) - waves_of(settings_.offsets, j);
    if (!is_corrected(j) || !std::isfinite(residual)) continue;
    const double sigma = double(sample.sigma_waves[k]);
    squares += residual * residual;
    Law& one = law_of(j);
    one.observed = true;
    one.law->observe(
        {sample.t_ns, residual, std::isfinite(sigma) ? sigma : 0.0, waves_of(shown, j)});
  }
  residual_rms_waves_ = std::sqrt(squares);
}

void ModalControl::step(std::int64_t t_ns) {
  at_limit_ = false;
  for (const auto& [j, one] : laws_) {
    if (!one.observed) continue;  // keeps its correction: nothing is known of the mode
    const double waves = one.law->step(t_ns, settings_.limit_waves);
    at_limit_ = at_limit_ || std::abs(waves) >= settings_.limit_waves;
    const auto known = std::ranges::find(correction_, j, &Mode::j);
    if (known != correction_.end()) {
      known->waves = waves;
    } else {
      correction_.push_back({j, waves});
    }
  }
  ++steps_;
}

}  // namespace ovws
