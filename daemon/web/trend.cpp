#include "daemon/web/trend.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws::web {

using nlohmann::json;

namespace {

double rounded(double value, double steps_per_unit) {
  return std::round(value * steps_per_unit) / steps_per_unit;
}

double rounded_waves(double waves) {
  return rounded(waves, 1e6);
}
double rounded_us(double us) {
  return rounded(us, 10.0);
}

}  // namespace

std::optional<json> Trend::add(const json& wavefront) {
  const auto t_ns = wavefront.at("t_arrival_ns").get<std::int64_t>();
  std::optional<json> done;
  // A clock set back also starts a new bin.
  if (t_ns - begin_ns_ >= bin_ns_ || t_ns < begin_ns_) {
    if (frames_ > 0) done = ended(std::clamp(t_ns, begin_ns_, begin_ns_ + bin_ns_));
    begin(t_ns);
  }
  ++frames_;
  gap_ += wavefront.at("gap").get<std::int64_t>();
  lost_max_ = std::max(
      lost_max_, wavefront.at("subapertures").get<int>() - wavefront.at("tracked").get<int>());
  latencies_us_.push_back(wavefront.at("latency_us").get<double>());
  if (wavefront.at("valid").get<bool>()) add_valid(wavefront);
  return done;
}

void Trend::begin(std::int64_t t_ns) {
  *this = Trend(bin_ns_);
  begin_ns_ = t_ns;
}

void Trend::add_valid(const json& wavefront) {
  auto j = wavefront.at("j").get<std::vector<int>>();
  if (j != j_) {
    j_ = std::move(j);
    sums_.assign(j_.size(), 0.0);
    valid_ = 0;
    rms_sum_ = rms_max_ = 0.0;
  }
  ++valid_;
  const double rms = wavefront.at("rms_waves").get<double>();
  rms_sum_ += rms;
  rms_min_ = valid_ == 1 ? rms : std::min(rms_min_, rms);
  rms_max_ = std::max(rms_max_, rms);
  const json& coefficients = wavefront.at("coefficients");
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += coefficients[i].get<double>();
}

json Trend::ended(std::int64_t t_ns) const {
  std::vector<double> sorted = latencies_us_;
  std::sort(sorted.begin(), sorted.end());
  json bin{{"schema", "ovws.web.trend/1"},
           {"bin_s", double(bin_ns_) * 1e-9},
           {"t_ns", t_ns},
           {"span_s", double(t_ns - begin_ns_) * 1e-9},
           {"frames", frames_},
           {"valid", valid_},
           {"gap", gap_},
           {"lost_max", lost_max_},
           {"latency_median_us", rounded_us(sorted[sorted.size() / 2])},
           {"latency_max_us", rounded_us(sorted.back())},
           {"rms_waves", nullptr},
           {"rms_min_waves", nullptr},
           {"rms_max_waves", nullptr},
           {"j", j_},
           {"coefficients", nullptr}};
  if (valid_ == 0) return bin;
  bin["rms_waves"] = rounded_waves(rms_sum_ / valid_);
  bin["rms_min_waves"] = rounded_waves(rms_min_);
  bin["rms_max_waves"] = rounded_waves(rms_max_);
  std::vector<double> means = sums_;
  for (double& mean : means) mean = rounded_waves(mean / valid_);
  bin["coefficients"] = means;
  return bin;
}

}  // namespace ovws::web
