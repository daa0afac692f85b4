#include "daemon/ovws/study/gain_sweep.hpp"

#include <cmath>
#include <utility>

namespace ovws {

const std::vector<std::string>& sweep_tracker_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = kNames<TrackerKind>();
    all.emplace_back("cell_centroid");
    return all;
  }();
  return names;
}

Json Wire<SweepTracker>::to_json(const SweepTracker& tracker) {
  return tracker.fixed_cell ? sweep_tracker_names().back()
                            : std::string(tracker_name(tracker.kind));
}

void Wire<SweepTracker>::decode(ObjectReader& reader, const FieldInfo& field, SweepTracker& out) {
  int value = int(out.kind);
  reader.choice(field.key, value, sweep_tracker_names());
  out.fixed_cell = std::size_t(value) == kNames<TrackerKind>().size();
  out.kind = out.fixed_cell ? TrackerKind::centroid : TrackerKind(value);
}

std::vector<ModesSet> paper_aberrations() {
  constexpr int kObliqueAstigmatism = 3;
  std::vector<ModesSet> all;
  for (const double unit_waves : {0.5, 1.5, 2.0}) {
    all.push_back({{{kObliqueAstigmatism, unit_waves / zernike_rms_factor(kObliqueAstigmatism)}}});
  }
  return all;
}

GainSweep::Cell GainSweep::cell(std::size_t number) const {
  const std::size_t row = number / arms.size();
  return {number % arms.size(), row / gains_db.size(), row % gains_db.size()};
}

double to_millionth(double value) {
  return std::round(1e6 * value) / 1e6;
}

namespace {

/// Arithmetic mean; NaN of an empty list.
double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / double(values.size());
}

CellVariance variance_of(const CellMeasured& cell) {
  CellVariance variance;
  std::vector<double> all, unsaturated;
  for (const CellMeasured::Frame& frame : cell.frames) {
    variance.saturated_frames += frame.saturated_fraction > 0.0 ? 1 : 0;
    variance.lost_spots += cell.subapertures - frame.tracked;
    if (!std::isfinite(frame.variance_rad2)) continue;
    all.push_back(frame.variance_rad2);
    if (frame.saturated_fraction == 0.0) unsaturated.push_back(frame.variance_rad2);
  }
  variance.mean = mean_of(all);
  double squares = 0.0;
  for (const double value : all) squares += (value - variance.mean) * (value - variance.mean);
  const double count = double(all.size());
  variance.standard_deviation = all.size() > 1 ? std::sqrt(squares / (count - 1.0)) : NAN;
  variance.standard_error = variance.standard_deviation / std::sqrt(count);
  variance.unsaturated = mean_of(unsaturated);
  variance.undetermined_frames = int(cell.frames.size() - all.size());
  return variance;
}

}  // namespace

CellSummary::CellSummary(CellMeasured measured)
    : CellMeasured(std::move(measured)), variance(variance_of(*this)) {}

}  // namespace ovws
