/// The largest aberration that is found without history, mode by mode.
#include <spdlog/fmt/fmt.h>

#include "core/tracking/acquisition.hpp"
#include "daemon/study/figure.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/sensor.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kStepWaves = 0.05;
constexpr double kMostWaves = 2.0;
constexpr double kSnr = 10.0;
constexpr double kGross = 0.5;  ///< lambda/d: further off is no spot of this subaperture

/// One mode in growing steps, each acquired as if nothing were known.
class Climber {
 public:
  Climber(const Geometry& geometry, int j)
      : j_(j),
        model_(model_of(geometry, 1)),
        measurer_(geometry, {"", 1, {TrackerKind::lg}}, model_),
        truth_(measurer_.reference_px()),
        before_(truth_) {}

  /// The largest amplitude (sign as given, RMS waves) up to which every spot was found, and none
  /// wrongly.
  double climb(double sign, std::uint64_t seed) {
    double reached = 0.0;
    const int steps = int(std::lround(kMostWaves / kStepWaves));
    for (int step = 1; step <= steps; ++step) {
      const double waves = step * kStepWaves;
      const std::vector<Mode> modes{{j_, sign * waves}};
      const auto light = model_->light(modes);
      if (!light) break;
      Image<float> light_e = *light;
      scale(light_e, kPeakE / model_->peak_of_spots(*light, modes));
      if (!follow(light_e)) break;
      if (!acquired(expose(light_e, read_noise_of_snr(kSnr), seed++))) break;
      reached = waves;
    }
    return reached;
  }

 private:
  /// The true positions, extrapolated from the steps before and tracked without noise.
  bool follow(const Image<float>& light) {
    std::vector<Vec2> expected(truth_.size());
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      expected[i] = truth_[i] + (truth_[i] - before_[i]);
    }
    before_ = truth_;
    truth_ = measurer_.noise_free_px(light, expected);
    for (const Vec2 at : truth_) {
      if (std::isnan(at.x)) return false;
    }
    return true;
  }

  bool acquired(const Exposure& exposure) const {
    Acquisition acquisition({1, measurer_.lambda_d_px()}, measurer_.reference_px(),
                            exposure.dn.width, exposure.dn.height);
    TrackScratch scratch = measurer_.tracker().make_scratch();
    std::vector<SpotFix> fixes(truth_.size());
    acquisition.acquire(exposure.view(), measurer_.tracker(), scratch, fixes);
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      const Vec2 at{fixes[i].x, fixes[i].y};
      if (!fixes[i].found() || norm(at - truth_[i]) > kGross * measurer_.lambda_d_px())
        return false;
    }
    return true;
  }

  int j_;
  std::shared_ptr<SensorModel> model_;
  Measurer measurer_;
  std::vector<Vec2> truth_, before_;
};

}  // namespace

Findings range(const Settings& settings) {
  std::vector<int> modes_j;
  for (int j = 1; j <= (settings.quick ? 4 : 14); ++j) modes_j.push_back(j);
  std::vector<double> reached(2 * modes_j.size());
  parallel_for("range", reached.size(), settings.threads, [&](std::size_t k) {
    Climber climber(default_bench(), modes_j[k / 2]);
    reached[k] = climber.climb(k % 2 == 0 ? 1.0 : -1.0, settings.seed + 1000 * k);
  });
  nlohmann::json summary{{"study", "range"},
                         {"unit", "waves, RMS-normalised"},
                         {"snr", kSnr},
                         {"step_waves", kStepWaves},
                         {"most_waves", kMostWaves},
                         {"rows", nlohmann::json::array()}};
  Figure figure{"range",
                fmt::format("Largest mode found without history (19 of 19 spots), SNR {}", kSnr),
                "OSA index j", "amplitude (waves RMS)"};
  for (const int side : {0, 1}) {
    Series series{side == 0 ? "positive" : "negative", {}, {}, {}};
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      series.x.push_back(modes_j[k]);
      series.y.push_back(reached[2 * k + std::size_t(side)]);
      summary["rows"].push_back({{"j", modes_j[k]},
                                 {"name", zernike_name(modes_j[k])},
                                 {"sign", side == 0 ? 1 : -1},
                                 {"waves", reached[2 * k + std::size_t(side)]}});
    }
    figure.series.push_back(std::move(series));
  }
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace ovws::study
