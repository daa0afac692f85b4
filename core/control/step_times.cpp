#include "core/control/step_times.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ovws {
namespace {

constexpr std::array kParts{&StepTimes::settle_ms,  &StepTimes::wait_ms,   &StepTimes::exposure_ms,
                            &StepTimes::compute_ms, &StepTimes::render_ms, &StepTimes::refresh_ms,
                            &StepTimes::present_ms};

}  // namespace

void StepLog::add(const LoopStep& step) {
  steps_[count_++ % kSteps] = step;
}

StepSummary StepLog::summary() const {
  const std::size_t known = std::min(count_, kSteps);
  StepSummary summary;
  summary.steps = int(known);
  if (known == 0) return summary;
  std::vector<double> totals;
  for (std::size_t k = 0; k < known; ++k) {
    const LoopStep& step = steps_[k];
    totals.push_back(step.times.total_ms());
    summary.delay_ms += step.delay_ms / double(known);
    summary.newest_share += (step.has_newest ? 1.0 : 0.0) / double(known);
    for (const auto part : kParts) summary.mean.*part += step.times.*part / double(known);
  }
  std::sort(totals.begin(), totals.end());
  summary.p50_ms = totals[known / 2];
  summary.p99_ms = totals[known * 99 / 100];
  return summary;
}

std::int64_t RecentTime::ns(double share) const {
  const std::size_t known = std::min(count_, kSteps);
  if (known == 0) return 0;
  auto sorted = last_ns_;
  const auto place = sorted.begin() + std::ptrdiff_t(std::ceil(share * double(known - 1)));
  std::nth_element(sorted.begin(), place, sorted.begin() + std::ptrdiff_t(known));
  return *place;
}

}  // namespace ovws
