#include "daemon/ovws/study/searcher.hpp"

#include <cmath>

#include "daemon/ovws/study/fitting.hpp"

namespace ovws::study {
namespace {

constexpr int kSearchRenderings = 14;

}  // namespace

Searcher::Searcher(const Geometry& geometry, const Measurer& measurer)
    : measurer_(measurer),
      acquisition_({measurer.method().charge, measurer.lambda_d_px()}, measurer.reference_px(),
                   kImagePx, kImagePx),
      scratch_(measurer.tracker().make_scratch()) {
  if (measurer.method().tracking.tracker != TrackerKind::fit) return;
  model_.emplace(renderer_of(geometry, measurer.method().charge, measurer.modes_j()),
                 kMaxSpotEstimates);
}

std::vector<SpotFix> Searcher::find(const Exposure& exposure, double read_noise_e) {
  std::vector<SpotFix> fixes(std::size_t(measurer_.spots()));
  acquisition_.acquire(exposure.view(), measurer_.tracker(), scratch_, fixes);
  return model_ ? fitted(exposure, read_noise_e, fixes) : fixes;
}

std::vector<SpotFix> Searcher::fitted(const Exposure& exposure, double read_noise_e,
                                      const std::vector<SpotFix>& by_positions) {
  const PixelNoise noise = noise_of(exposure, read_noise_e);
  const std::vector<double> flat(measurer_.modes_j().size(), 0.0);
  std::vector<std::vector<double>> starts{measurer_.modes(by_positions), flat};
  if (std::isnan(starts.front().front())) starts.erase(starts.begin());
  const auto found = model_->templates(exposure.view(), noise, starts, {}, kSearchRenderings);
  if (found) return (*found)->measure(exposure.view()).spots;
  return std::vector<SpotFix>(by_positions.size());
}

}  // namespace ovws::study
