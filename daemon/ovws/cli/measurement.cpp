#include "daemon/ovws/cli/measurement.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/pipeline/frame_rules.hpp"
#include "core/pipeline/position_modes.hpp"
#include "core/tracking/patch.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws::cli {
namespace {

constexpr int kRenderings = 14;  // 12 find 0.8 wave RMS from a flat start

/// Start coefficients of a fit: 0 for modes that were not measured.
std::vector<double> known(std::span<const float> coefficients) {
  std::vector<double> waves(coefficients.begin(), coefficients.end());
  std::replace_if(
      waves.begin(), waves.end(), [](double one) { return !std::isfinite(one); }, 0.0);
  return waves;
}

Result<std::unique_ptr<MeasurementPlan>> plan_for(const Config& config, const ImageView& like,
                                                  const std::optional<Reference>& reference) {
  auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return fail(lattice.error());
  const Roi roi{0, 0, like.width, like.height};
  auto builder = PlanBuilder::make(
      {{*lattice, config.sensor, config.tracking, config.optics, config.slm.geometry, roi,
        like.format},
       1,
       lit_pixels(config.camera.settings.pixel_format, config.optics.wavelength_nm),
       reference ? &*reference : nullptr});
  if (!builder) return fail(builder.error());
  return builder->plan(1, 1, {});
}

Vec2 position_of(const SpotFix& spot) {
  return {double(spot.x), double(spot.y)};
}

std::vector<Vec2> positions_of(std::span<const SpotFix> spots) {
  std::vector<Vec2> positions;
  for (const SpotFix& spot : spots) positions.push_back(position_of(spot));
  return positions;
}

/// Numbers of the spots that were not found, as text; empty if all were found.
std::string missing(const Measured& measured) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < measured.spots.size(); ++i) {
    if (!measured.spots[i].found()) numbers.push_back(int(i));
  }
  return fmt::format("{}", fmt::join(numbers, ", "));
}

/// How far the lattice of the spots found is turned against `expected`, degrees. No wavefront turns
/// it: the displacements that it makes are a gradient.
double rotation_deg(std::span<const Vec2> expected, std::span<const SpotFix> spots) {
  double count = 0.0;
  Vec2 from, to;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!spots[i].found()) continue;
    from = from + expected[i];
    to = to + position_of(spots[i]);
    ++count;
  }
  if (count == 0.0) return 0.0;
  double along = 0.0, across = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!spots[i].found()) continue;
    const Vec2 a = expected[i] - (1.0 / count) * from;
    const Vec2 b = position_of(spots[i]) - (1.0 / count) * to;
    along += a.x * b.x + a.y * b.y;
    across += a.x * b.y - a.y * b.x;
  }
  return std::atan2(across, along) * 180.0 / std::numbers::pi;
}

}  // namespace

OperatorReport operator_report(const TrackingSettings& tracking) {
  if (tracking.mode_operator != OperatorKind::measured) return {tracking.mode_operator, ""};
  return {OperatorKind::slopes, "only a running daemon has the measured matrix"};
}

Result<void> check_rotation(const Config& config, const MeasurementPlan& plan,
                            std::span<const SpotFix> spots, std::string_view field) {
  constexpr double kMaxDeg = 0.5;  // of 0.15 wave of coma, less than 0.002 are lost
  if (config.modulator != Modulator::fixed) return {};
  const double turned = rotation_deg(plan.predicted_px, spots);
  if (std::abs(turned) <= kMaxDeg) return {};
  return fail(Errc::refused, std::string(field),
              fmt::format("the array is turned by {:.1f} degrees in the image, which is not "
                          "modelled: turn the camera or the images",
                          turned));
}

Measurement::Measurement(std::unique_ptr<MeasurementPlan> plan)
    : plan_(std::move(plan)),
      acquisition_(plan_->spots, plan_->predicted_px, plan_->roi.width, plan_->roi.height, nullptr,
                   std::nullopt, plan_->kinds),
      track_scratch_(plan_->make_scratch()),
      solve_scratch_(plan_->reconstructor->make_scratch()) {}

Result<Measurement> Measurement::make(const Config& config, const ImageView& like,
                                      const std::optional<ImageView>& reference,
                                      const std::optional<RefineCamera>& camera) {
  auto by_model = plan_for(config, like, std::nullopt);
  if (!by_model) return fail(by_model.error());
  Reference taken;
  taken.positions_px = (*by_model)->predicted_px;
  std::vector<float> absolute((*by_model)->modes_j.size(), 0.0F);  // coefficients of the reference
  if (reference) {
    if (reference->width != like.width || reference->height != like.height) {
      return fail(Errc::invalid, "reference",
                  "the reference image has " + std::to_string(reference->width) + " x " +
                      std::to_string(reference->height) + " pixels, the image " +
                      std::to_string(like.width) + " x " + std::to_string(like.height) +
                      ": use images of the same camera region");
    }
    auto from_model = plan_for(config, like, taken);
    if (!from_model) return fail(from_model.error());
    Measurement first(std::move(*from_model));
    const Measured measured = first.measure(*reference);
    if (const std::string which = missing(measured); !which.empty()) {
      return fail(Errc::invalid, "reference",
                  "these spots are not found in the reference image: " + which +
                      (measured.saturated > 0.0 ? "; spots are saturated: lower the exposure or "
                                                  "the gain"
                                                : ""));
    }
    taken.positions_px = positions_of(measured.spots);
    const auto straight = check_rotation(config, *first.plan_, measured.spots, "reference");
    if (!straight) return fail(straight.error());
    absolute = measured.coefficients;
  }
  auto plan = plan_for(config, like, taken);
  if (!plan) return fail(plan.error());
  Measurement made(std::move(*plan));
  made.camera_ = camera;
  made.mode_operator_ = operator_report(config.tracking);
  if (config.tracking.tracker != TrackerKind::fit) return made;
  if (auto used = made.use_templates(config, like, reference, absolute); !used) {
    return fail(used.error());
  }
  return made;
}

/// Makes the rendered model for the tracker `fit`. `start`: modes of the reference image, measured
/// by spot positions.
Result<void> Measurement::use_templates(const Config& config, const ImageView& like,
                                        const std::optional<ImageView>& reference,
                                        std::span<const float> start) {
  auto renderer = SpotRenderer::make(config.sensor, config.slm.geometry, config.optics, like.width,
                                     like.height, plan_->modes_j, {.lit = plan_->spots.lit});
  if (!renderer && !reference && !camera_) return {};  // the image is too small for a spot
  if (!renderer) return fail(renderer.error());
  PointModel model(std::move(*renderer), config.tracking.estimates);
  if (reference) {
    const std::vector<double> waves = known(start);
    const PixelNoise noise =
        camera_ ? pixel_noise(*camera_) : noise_of(*reference, model.rendered(waves));
    if (auto used = model.use_reference(*reference, noise, waves, {}); !used) {
      Error error = used.error();
      error.reason +=
          ": check that optics, sensor and slm in the configuration match the bench, "
          "or measure positions only (tracker lg)";
      return fail(std::move(error));
    }
  }
  model_.emplace(std::move(model));
  counts_from_image_ = reference.has_value();
  return {};
}

/// Start wavefronts of the fit: the one measured by spot positions, and the reference (all modes
/// 0).
std::vector<std::vector<double>> Measurement::starts(const Measured& measured) const {
  std::vector<std::vector<double>> all;
  if (measured.reconstruction.determined) all.push_back(known(measured.coefficients));
  all.emplace_back(plan_->modes_j.size());
  return all;
}

void Measurement::fit(const ImageView& image, Measured& measured) {
  const auto found = model_->templates(image, starts(measured), {}, kRenderings);
  if (!found) return;
  FrameFit::Measured all = (*found)->measure(image);
  measured.fitted = true;
  measured.verdict = Verdict::valid;
  measured.branch_points.clear();
  measured.coefficients = std::move(all.coefficients);
  measured.sigma_waves = std::move(all.sigma_waves);
  measured.spots = std::move(all.spots);
  measured.reconstruction = reconstruction_of(all.frame, plan_->modes_j, measured.coefficients);
}

/// Refines an image with the noise of the known camera. If no start leads to a fit that explains
/// the image, the image is not valid.
void Measurement::refine(const ImageView& image, Measured& measured) {
  for (const std::vector<double>& start : starts(measured)) {
    const PointModel::Starts one(&start, 1);
    std::shared_ptr<const FrameFit> templates;
    auto found = counts_from_image_ ? ovws::refine(*model_, image, *camera_, one, {}, templates)
                                    : refine_absolute(*model_, image, *camera_, one, {});
    measured.refused = found ? found->doubt(*camera_).value_or("") : found.error().reason;
    if (!found) continue;
    measured.fitted = true;
    measured.refined = std::move(*found);
    break;
  }
  measured.verdict = measured.refused.empty() ? Verdict::valid : Verdict::unexplained;
}

/// Measures the image by spot positions; the verdict if nothing but the positions is known.
Verdict Measurement::by_positions(Measured& measured) {
  std::vector<Vec2> left_px(measured.spots.size());
  FoundBranchPoints found;
  measured.reconstruction = reconstruct_positions(*plan_, measured.spots, solve_scratch_, left_px,
                                                  measured.coefficients, found);
  measured.branch_points.assign(found.points.begin(), found.points.begin() + found.count);
  const bool enough = enough_found(measured.spots, plan_->reference_px);
  if (!measured.reconstruction.determined) {
    return enough ? Verdict::undetermined : Verdict::spots_lost;
  }
  if (!measured.branch_points.empty()) return Verdict::branch_points;
  if (!is_explained(measured.reconstruction, measured.spots, plan_->spots.lambda_d_px)) {
    return enough ? Verdict::unexplained : Verdict::spots_lost;
  }
  return plan_->positions_suffice() ? Verdict::valid : Verdict::unconfirmed;
}

Measured Measurement::measure(const ImageView& image) {
  Measured measured;
  measured.spots.resize(std::size_t(plan_->subapertures()));
  measured.coefficients.resize(plan_->modes_j.size(), NAN);
  measured.sigma_waves.resize(plan_->modes_j.size(), NAN);
  measured.mode_operator = mode_operator_;
  acquisition_.acquire(image, *plan_->tracker, track_scratch_, measured.spots);
  measured.verdict = by_positions(measured);
  const bool fits = model_ && image.width == plan_->roi.width && image.height == plan_->roi.height;
  if (fits && camera_) refine(image, measured);
  if (fits && !camera_) fit(image, measured);
  measured.tracked = int(std::count_if(measured.spots.begin(), measured.spots.end(),
                                       [](const SpotFix& spot) { return spot.found(); }));
  const int half_px = int(plan_->spots.lambda_d_px);
  for (std::size_t i = 0; i < measured.spots.size(); ++i) {
    SpotFix& spot = measured.spots[i];
    if (!spot.found()) spot.peak = brightest_pixel(image, plan_->predicted_px[i], half_px);
  }
  const double full = full_scale_dn(image.format);
  const auto saturated = std::count_if(measured.spots.begin(), measured.spots.end(),
                                       [&](const SpotFix& spot) { return spot.peak >= full; });
  measured.saturated = double(saturated) / double(measured.spots.size());
  return measured;
}

}  // namespace ovws::cli
