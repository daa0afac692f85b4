#include "daemon/ovws/cli/measurement.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "core/pipeline/frame_rules.hpp"
#include "core/tracking/patch.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/sensor/reference_templates.hpp"

namespace ovws::cli {
namespace {

Error unreadable(const std::string& path, const std::string& why) {
  return {Errc::invalid, "image", path + " " + why};
}

template <class T>
Image<T> pixels_of(const cv::Mat& mat) {
  Image<T> image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr<T>(y), mat.cols, image.row(y));
  return image;
}

Result<std::unique_ptr<MeasurementPlan>> plan_for(const Config& config, const ImageView& like,
                                                  const std::optional<Reference>& reference,
                                                  const OwnTemplates& own = {},
                                                  const ModeOperator* mode_operator = nullptr) {
  auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return fail(lattice.error());
  const Roi roi{0, 0, like.width, like.height};
  const std::vector<Mode> nothing_shown;
  return build_plan(
      {1, 1, 1, *lattice, config.sensor, config.tracking, config.optics, config.slm.geometry, roi,
       like.format, lit_pixels(config.camera.settings.pixel_format, config.optics.wavelength_nm),
       nothing_shown, reference ? &*reference : nullptr, nullptr, own.banks, mode_operator});
}

/// The configured operator for images of this size; null: the plan's slopes operator is used.
Result<std::unique_ptr<const ModeOperator>> operator_for(const Config& config,
                                                         const ImageView& like) {
  if (config.tracking.mode_operator == OperatorKind::measured) {
    return fail(Errc::refused, "operator",
                "a measured matrix exists only in a running daemon: choose slopes, diffractive or "
                "relinearised");
  }
  if (config.tracking.mode_operator != OperatorKind::diffractive) return nullptr;
  const OperatorKey key =
      operator_key(config.sensor, config.tracking, config.optics, {0, 0, like.width, like.height});
  auto made = diffractive_operator(key, config.slm.geometry);
  if (!made) return fail(made.error());
  return std::make_unique<const ModeOperator>(std::move(*made));
}

/// Requires what plan_for has accepted.
ShapedAcquisition acquisition_for(const Config& config, const MeasurementPlan& plan) {
  const Lattice lattice = *make_lattice(config.sensor, config.slm.geometry);
  const PxPerCycle map = px_per_cycle(config.optics, config.slm.geometry);
  const std::vector<int>& modes_j = plan.reconstructor->modes_j();
  const Eigen::MatrixXd slopes = slope_matrix(
      lattice, config.sensor, modes_j, slope_model(config.sensor.charge, config.tracking), map);
  return {lattice,           config.sensor,  plan.spots,     map, modes_j, slopes,
          plan.predicted_px, plan.roi.width, plan.roi.height};
}

std::vector<Vec2> positions_of(std::span<const SpotFix> spots) {
  std::vector<Vec2> positions;
  for (const SpotFix& spot : spots) positions.push_back({double(spot.x), double(spot.y)});
  return positions;
}

/// The numbers of spots without a usable reference position: not found, or split. Empty: none.
std::string missing(const Measured& measured) {
  std::vector<int> numbers = measured.split;
  for (std::size_t i = 0; i < measured.spots.size(); ++i) {
    if (!measured.spots[i].found()) numbers.push_back(int(i));
  }
  std::sort(numbers.begin(), numbers.end());
  return fmt::format("{}", fmt::join(numbers, ", "));
}

}  // namespace

ImageView Picture::view() const {
  return narrow.pixels.empty() ? view_of(wide, PixelFormat::mono16) : view_of(narrow);
}

Result<Picture> read_picture(const std::string& path) {
  if (std::error_code none; !std::filesystem::exists(path, none)) {
    return fail(unreadable(path, "does not exist"));
  }
  cv::Mat mat;
  try {
    mat = cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return fail(unreadable(path, "cannot be read: the size in its header is too large"));
  }
  if (mat.empty()) return fail(unreadable(path, "cannot be read as an image"));
  Picture picture;
  if (mat.type() == CV_8UC1) {
    picture.narrow = pixels_of<std::uint8_t>(mat);
  } else if (mat.type() == CV_16UC1) {
    picture.wide = pixels_of<std::uint16_t>(mat);
  } else {
    return fail(unreadable(
        path, "is not greyscale with 8 or 16 bits: convert it, e.g. to a greyscale TIFF"));
  }
  return picture;
}

Measurement::Measurement(const Config& config, std::unique_ptr<MeasurementPlan> plan,
                         TemplateReport templates)
    : plan_(std::move(plan)),
      templates_(std::move(templates)),
      acquisition_(acquisition_for(config, *plan_)),
      track_scratch_(plan_->tracker->make_scratch()),
      solve_scratch_(plan_->reconstructor->make_scratch()) {}

Result<Measurement> Measurement::make(const Config& config, const ImageView& like,
                                      const std::optional<ImageView>& reference) {
  auto by_model = plan_for(config, like, std::nullopt);
  if (!by_model) return fail(by_model.error());
  const SpotModel spots = (*by_model)->spots;
  Reference taken;
  taken.positions_px = (*by_model)->predicted_px;
  const auto mode_operator = operator_for(config, like);
  if (!mode_operator) return fail(mode_operator.error());
  if (reference) {
    if (reference->width != like.width || reference->height != like.height) {
      return fail(Errc::invalid, "reference",
                  "the reference image differs in size from the image: both must be equal");
    }
    Measurement first(config, std::move(*by_model));
    const Measured measured = first.measure(*reference);
    if (const std::string which = missing(measured); !which.empty()) {
      return fail(Errc::invalid, "reference",
                  "these spots are not found in the reference image: " + which);
    }
    taken.positions_px = positions_of(measured.spots);
    taken.picture = std::make_shared<ReferencePicture>(picture_of(*reference));
  } else if (*mode_operator) {
    const std::vector<Vec2>& flat_px = (*mode_operator)->flat_px;
    for (std::size_t i = 0; i < flat_px.size(); ++i) {
      if (std::isfinite(flat_px[i].x)) taken.positions_px[i] = flat_px[i];
    }
  }
  const OwnTemplates own = own_templates(config.tracking, spots, reference ? &taken : nullptr);
  auto plan = plan_for(config, like, taken, own, mode_operator->get());
  if (!plan) return fail(plan.error());
  Measurement made(config, std::move(*plan), own.report);
  if (config.tracking.mode_operator == OperatorKind::relinearised) {
    auto relineariser = Relineariser::make(config, *made.plan_, reference.has_value());
    if (!relineariser) return fail(relineariser.error());
    made.relineariser_ = std::move(*relineariser);
  }
  return made;
}

/// Refines the linear estimate by relinearised steps. If they fail, the linear estimate stays and
/// `mode_operator.reason` says why.
void Measurement::relinearise(Measured& measured) {
  if (!measured.reconstruction.determined) {
    measured.mode_operator.reason = "too few spots were found for a start";
    return;
  }
  const auto found = relineariser_->measure(measured.spots, measured.split, measured.coefficients);
  if (!found) {
    measured.mode_operator.reason = found.error().reason;
    return;
  }
  double squares = 0.0;
  for (std::size_t k = 0; k < found->waves.size(); ++k) {
    measured.coefficients[k] = float(found->waves[k]);
    if (plan_->reconstructor->modes_j()[k] > 2) squares += found->waves[k] * found->waves[k];
  }
  measured.reconstruction.rms_waves = std::sqrt(squares);
  measured.reconstruction.fit_residual_px = found->fit_residual_px;
  measured.mode_operator.in_force = OperatorKind::relinearised;
}

Measured Measurement::measure(const ImageView& image) {
  Measured measured;
  measured.spots.resize(std::size_t(plan_->subapertures()));
  measured.coefficients.resize(plan_->reconstructor->modes_j().size(), NAN);
  measured.tracked = acquisition_.acquire(image, *plan_->tracker, track_scratch_, measured.spots);
  for (std::size_t i = 0; i < measured.spots.size(); ++i) {
    if (acquisition_.split()[i]) measured.split.push_back(int(i));
  }
  measured.reconstruction = plan_->reconstructor->solve_without_outliers(
      measured.spots, solve_scratch_, measured.coefficients,
      kCredibleResidual * plan_->spots.lambda_d_px);
  measured.tracked = int(std::count_if(measured.spots.begin(), measured.spots.end(),
                                       [](const SpotFix& spot) { return spot.found(); }));
  measured.mode_operator = {plan_->mode_operator, ""};
  if (relineariser_) relinearise(measured);
  measured.explained =
      !measured.reconstruction.determined ||
      is_explained(measured.reconstruction, measured.spots, plan_->spots.lambda_d_px);
  measured.valid = measured.reconstruction.determined && measured.explained;
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
