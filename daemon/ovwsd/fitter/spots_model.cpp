#include "daemon/ovwsd/fitter/spots_model.hpp"

#include <algorithm>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr double kMeasuredReachWaves = 0.02;  // RMS distance from the calibration's wavefront

PixelNoise in_16_bits(PixelNoise noise, PixelFormat format) {
  const double scale = to_16_bits(format);
  noise.constant_dn2 *= scale * scale;
  noise.per_dn *= scale;
  noise.saturated_dn *= scale;
  return noise;
}

/// Mean image of a reference in 16-bit DN, and its noise. `of_frame`: noise of a single frame in
/// 16-bit DN, which averaging reduces.
struct MeanImage {
  Image<std::uint16_t> dn;
  PixelNoise noise;

  MeanImage(const ReferenceImage& picture, const PixelNoise& of_frame)
      : dn(in_16_bits(picture.mean_dn, picture.format)), noise(of_frame) {
    noise.constant_dn2 /= picture.frames;
    noise.per_dn /= picture.frames;
  }
  ImageView view() const { return view_of(dn, PixelFormat::mono16); }
};

Result<MeasuredModel> measured_model(const SensorSnapshot& sensor,
                                     std::span<const ImageView> images) {
  const MeasuredShapes& shapes = *sensor.calibration->shapes;
  if (!shapes.are_inside(images.back().width, images.back().height)) {
    return fail(Errc::refused, "calibration", "its spots lie outside the image: calibrate again");
  }
  if (shapes.lit() != lit_pixels(images.back().format, sensor.optics.wavelength_nm)) {
    return fail(Errc::refused, "calibration",
                "it was measured with other colour filters than those of " +
                    std::string(pixel_format_name(images.back().format)) + ": calibrate again");
  }
  MeasuredModel model(shapes.spots, shapes.modes_j, sensor.tracking.estimates);
  const MeanImage mean(*sensor.reference->picture,
                       in_16_bits(noise_of(images, model.spots()), images.back().format));
  if (auto used = model.use_reference(mean.view(), mean.noise); !used) return fail(used.error());
  return model;
}

}  // namespace

ModelKey::ModelKey(const FrameCopy& frame, const SensorSnapshot& sensor)
    : sensor_epoch(frame.sensor_epoch),
      cols(frame.frame.image.width),
      rows(frame.frame.image.height),
      lit(lit_pixels(frame.frame.image.format, sensor.optics.wavelength_nm)),
      modes_j(sensor.modes_j),
      estimates(sensor.tracking.estimates),
      reference_taken_ns(sensor.reference ? sensor.reference->t_taken_ns : 0) {}

std::vector<Mode> fixed_modes(const std::vector<Mode>& shown, const std::vector<int>& measured) {
  std::vector<Mode> fixed;
  for (const Mode& mode : shown) {
    const bool is_measured = std::find(measured.begin(), measured.end(), mode.j) != measured.end();
    if (!is_measured) fixed.push_back(mode);
  }
  return fixed;
}

std::vector<Mode> fixed_modes(const SensorSnapshot& sensor) {
  return fixed_modes(shown_modes(HologramKind::sensor, sensor.aberration, sensor.correction),
                     sensor.modes_j);
}

std::optional<std::vector<double>> modes_against_model(const SensorSnapshot& sensor,
                                                       const SlmGeometry& slm, int cols, int rows,
                                                       std::span<const SpotFix> spots) {
  const auto lattice = make_lattice(sensor.sensor, slm);
  if (!lattice) return std::nullopt;
  const Reconstructor by_model(
      slope_matrix(*lattice, sensor.sensor, sensor.position_modes_j,
                   tilt_radii(*lattice, sensor.tracking), px_per_cycle(sensor.optics, slm)),
      sensor.position_modes_j,
      model_spots_px(*lattice, sensor.sensor, slm, sensor.optics, cols, rows));
  auto scratch = by_model.make_scratch();
  std::vector<float> leading(by_model.modes_j().size());
  if (!by_model.solve(spots, scratch, leading).determined) return std::nullopt;
  std::vector<double> waves(leading.begin(), leading.end());
  waves.resize(sensor.modes_j.size(), 0.0);
  return waves;
}

Result<PointModel> rendered_model(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                  const ImageView& like, const FrameNoise& frame_noise) {
  const int cols = like.width, rows = like.height;
  const LitPixels lit = lit_pixels(like.format, sensor.optics.wavelength_nm);
  auto renderer = SpotRenderer::make(sensor.sensor, slm, sensor.optics, cols, rows, sensor.modes_j,
                                     {.lit = lit});
  if (!renderer) return fail(renderer.error());
  PointModel model(std::move(*renderer), sensor.tracking.estimates);
  if (!sensor.reference || sensor.reference->source == ReferenceSource::model) return model;
  if (!sensor.reference->picture) return fail(Errc::refused, "reference", kNoImage);
  const PixelFormat taken = sensor.reference->picture->format;
  if (lit_pixels(taken, sensor.optics.wavelength_nm) != lit) {
    return fail(Errc::refused, "reference",
                "the reference was taken in " + std::string(pixel_format_name(taken)) +
                    ", and its colour filters are not those of " +
                    std::string(pixel_format_name(like.format)) + ": take a new reference");
  }
  std::vector<SpotFix> spots;
  for (const Vec2 at : known_positions(*sensor.reference)) {
    spots.push_back({float(at.x), float(at.y)});
  }
  const auto start = modes_against_model(sensor, slm, cols, rows, spots);
  if (!start) return fail(Errc::refused, "reference", "too few spots of the reference are known");
  const auto [noise, format] = frame_noise(model);
  const MeanImage mean(*sensor.reference->picture, in_16_bits(noise, format));
  auto used = model.use_reference(mean.view(), mean.noise, *start,
                                  fixed_modes(sensor.reference->aberration, sensor.modes_j));
  if (!used) return fail(used.error());
  return model;
}

Result<SpotsModel> SpotsModel::make(const SensorSnapshot& sensor, const SlmGeometry& slm,
                                    std::span<const ImageView> images) {
  if (!sensor.reference->picture) return fail(Errc::refused, "reference", kNoImage);
  SpotsModel made;
  const ImageView& like = images.back();
  made.rendered_ = rendered_model(sensor, slm, like, [&](PointModel& model) {
    const std::vector<double> flat(sensor.modes_j.size());
    return std::pair(noise_of(images, model.rendered(flat)), like.format);
  });
  if (auto used = made.use_calibration(sensor, images); !used) return fail(used.error());
  return made;
}

Result<void> SpotsModel::use_calibration(const SensorSnapshot& sensor,
                                         std::span<const ImageView> images) {
  measured_.reset();
  unmeasured_.clear();
  if (rendered_) rendered_->end_correction();
  if (sensor.templates_for.calibration_taken_ns == 0) {
    return rendered_ ? Result<void>{} : fail(rendered_.error());
  }
  auto measured = measured_model(sensor, images);
  if (!measured) {
    unmeasured_ = measured.error().reason;
    return rendered_ ? Result<void>{} : fail(Errc::refused, "reference", unmeasured_);
  }
  measured_ = std::move(*measured);
  if (!rendered_) return {};
  std::vector<double> calibrated = measured_->reference_waves();
  for (double& waves : calibrated) waves = -waves;
  rendered_->correct_by(*sensor.calibration->shapes, calibrated);
  return {};
}

std::shared_ptr<const FrameFit> SpotsModel::measured_near(std::span<const ImageView> images) const {
  if (!measured_) return nullptr;
  auto fit = measured_->templates(images);
  return fit && (*fit)->at_point().drift_waves < kMeasuredReachWaves ? std::move(*fit) : nullptr;
}

Result<std::shared_ptr<const FrameFit>> SpotsModel::templates(
    std::span<const ImageView> images, std::span<const std::vector<double>> starts,
    std::span<const Mode> fixed, int renderings) {
  if (auto near = measured_near(images)) return near;
  if (!rendered_) return measured_->templates(images);
  auto fit = rendered_->templates(images, starts, fixed, renderings);
  return fit || !measured_ ? fit : measured_->templates(images);
}

}  // namespace ovws
