#include "daemon/ovwsd/sensor/reference_templates.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "core/tracking/reference_shape.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {
namespace {

constexpr double kMaxMiB = 256.0;

OwnTemplates no_templates(std::string reason) {
  return {{}, {0, std::move(reason)}};
}

double bank_mib(const SpotModel& spots) {
  const TemplateBank bank(spots, ModelShape(spots, 1.5 * matched_window(spots.charge) + 1.0));
  const double planes = 3.0 + double(kNoiseLevels.size());
  const double shifts = 1.0 / (bank.step_px() * bank.step_px());
  return planes * shifts * bank.columns() * bank.rows() * double(sizeof(float)) / 1048576.0;
}

std::vector<int> missing_spots(const std::vector<std::shared_ptr<const TemplateBank>>& banks) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < banks.size(); ++i) {
    if (!banks[i]) numbers.push_back(int(i));
  }
  return numbers;
}

}  // namespace

OwnTemplates own_templates(const TrackingSettings& tracking, const SpotModel& spots,
                           const Reference* reference) {
  if (tracking.templates == TemplateKind::model) return no_templates("");
  if (tracking.tracker != TrackerKind::matched) {
    return no_templates("only the tracker matched uses templates: set tracker to matched");
  }
  if (reference == nullptr) return no_templates("there is no reference: take one");
  if (!reference->picture) return no_templates(kNoPicture);
  if (!shows(reference->picture->format, spots.lit)) {
    return no_templates(
        fmt::format("the reference's mean image has the pixel format {}: take it again",
                    pixel_format_name(reference->picture->format)));
  }
  const double needed_mib = bank_mib(spots) * double(reference->positions_px.size());
  if (needed_mib > kMaxMiB) {
    return no_templates(
        fmt::format("they would need {:.0f} MiB of memory (limit {:.0f}): set template to model",
                    needed_mib, kMaxMiB));
  }
  OwnTemplates own;
  own.banks = reference_templates(spots, reference->picture->mean_dn, reference->positions_px);
  const std::vector<int> without = missing_spots(own.banks);
  own.report.own = int(own.banks.size() - without.size());
  if (!without.empty()) {
    own.report.reason = fmt::format(
        "the reference's mean image of spots {} is saturated or too dark: correct the exposure, "
        "then take it again",
        listed_spots(without));
  }
  if (own.report.own == 0) own.banks.clear();
  return own;
}

const OwnTemplates& TemplateCache::of(const TrackingSettings& tracking, const SpotModel& spots,
                                      const Reference* reference) {
  const bool referenced = reference != nullptr;
  const auto picture = referenced ? reference->picture : nullptr;
  const bool cached = made_ && tracking == tracking_ && referenced_ == referenced &&
                      picture == picture_ && spots == spots_;
  if (!cached) {
    made_.reset();
    made_ = own_templates(tracking, spots, reference);
    tracking_ = tracking;
    spots_ = spots;
    referenced_ = referenced;
    picture_ = picture;
  }
  return *made_;
}

}  // namespace ovws
