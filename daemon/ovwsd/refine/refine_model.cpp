#include "daemon/ovwsd/refine/refine_model.hpp"

#include <cmath>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr const char* kNoGainInDb =
    "the camera has no gain in dB, so electrons_per_dn at its gain is unknown: refined needs "
    "another camera";

}  // namespace

/// The cache for one sensor and image size: refiner, and the linear estimate that gives its
/// starting point.
struct RefineModel::Bench {
  SensorConfig sensor;
  TrackingConfig tracking;
  int cols = 0, rows = 0;
  OpticsConfig optics;
  std::vector<int> modes_j;
  bool spot_amplitudes = false;
  Refiner refiner;
  Reconstructor by_model;  ///< from spots to the leading modes, absolute
  Reconstructor::Scratch scratch;

  bool is_for(const FrameCopy& frame, const SensorSnapshot& now,
              const RefineSetup& settings) const {
    return sensor == now.sensor && tracking == now.tracking && modes_j == now.modes_j &&
           by_model.modes_j() == now.position_modes_j &&
           spot_amplitudes == settings.spot_amplitudes && cols == frame.image.width &&
           rows == frame.image.height && optics.registered == now.optics.registered &&
           optics.centre_px == now.optics.centre_px;
  }
  std::optional<std::vector<double>> start_of(std::span<const SpotFix> spots) {
    std::vector<float> waves(modes_j.size());
    const auto leading = std::span(waves).first(by_model.modes_j().size());
    if (!by_model.solve(spots, scratch, leading).determined) return std::nullopt;
    return std::vector<double>(waves.begin(), waves.end());
  }
};

struct RefineModel::RefinedReference {
  std::shared_ptr<const ReferencePicture> picture;
  RefineSetup settings;
  Result<RefinedModes> modes;  ///< a failure is kept, too: the same image would fail again
};

RefineModel::RefineModel(const SlmGeometry& slm, const std::atomic<bool>& stop)
    : slm_(slm), stop_(stop) {}
RefineModel::~RefineModel() = default;

RefinedFrame RefineModel::refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                                 const RefineSetup& settings) {
  RefinedFrame out;
  const bool measured = sensor.reference && sensor.reference->source == ReferenceSource::measured;
  out.against_reference = measured;
  const auto refused = [&out](std::string why) {
    out.refusal = std::move(why);
    return out;
  };
  if (traits_of(frame.image.format).filter != ColourFilter::none) {
    return refused("the model does not support colour filters: set a Mono pixel_format");
  }
  if (std::isnan(frame.gain_db)) return refused(kNoGainInDb);
  if (auto made = make_bench(frame, sensor, settings); !made) return refused(made.error().reason);
  std::optional<std::vector<double>> start;
  const RefinedModes* reference = nullptr;
  if (measured) {
    const auto& modes = refined_reference(*sensor.reference, settings);
    if (!modes) return refused("the reference cannot be refined: " + modes.error().reason);
    reference = &*modes;
    start = modes->waves;
    for (std::size_t k = 0; k < start->size(); ++k) (*start)[k] += double(frame.coefficients[k]);
  } else {
    start = bench_->start_of(frame.spots);
    if (!start) return refused("too few spots were found to start the fit");
  }
  const RefineCamera camera = refine_camera(settings, frame.image.format, frame.gain_db, 1);
  const std::int64_t begun_ns = monotonic_ns();
  const auto found = bench_->refiner.refine(frame.image, camera, *start);
  out.duration_ms = 1e-6 * double(monotonic_ns() - begun_ns);
  if (!found) return refused(found.error().reason);
  out.modes = refined_modes(*found);
  if (reference != nullptr) out.modes = minus(std::move(*out.modes), *reference);
  out.refusal = out.modes->doubt(camera).value_or("");
  return out;
}

Result<void> RefineModel::make_bench(const FrameCopy& frame, const SensorSnapshot& sensor,
                                     const RefineSetup& settings) {
  if (bench_ && bench_->is_for(frame, sensor, settings)) return {};
  bench_.reset();
  reference_.reset();
  const int cols = frame.image.width, rows = frame.image.height;
  RefineOptions options;
  options.spot_amplitudes = settings.spot_amplitudes;
  options.stop = &stop_;
  auto refiner =
      Refiner::make(sensor.sensor, slm_, sensor.optics, cols, rows, sensor.modes_j, options);
  if (!refiner) return fail(refiner.error());
  const auto lattice = make_lattice(sensor.sensor, slm_);
  if (!lattice) return fail(lattice.error());
  Reconstructor by_model(slope_matrix(*lattice, sensor.sensor, sensor.position_modes_j,
                                      slope_model(sensor.sensor.charge, sensor.tracking),
                                      camera_px_per_cycle(sensor.optics, slm_)),
                         sensor.position_modes_j,
                         model_spots_px(*lattice, sensor.sensor, slm_, sensor.optics, cols, rows));
  auto scratch = by_model.make_scratch();
  bench_ = std::make_unique<Bench>(Bench{
      sensor.sensor, sensor.tracking, cols, rows, sensor.optics, sensor.modes_j,
      settings.spot_amplitudes, std::move(*refiner), std::move(by_model), std::move(scratch)});
  return {};
}

const Result<RefinedModes>& RefineModel::refined_reference(const Reference& reference,
                                                           const RefineSetup& settings) {
  const bool cached = reference_ && reference_->picture == reference.picture &&
                      same_fit(reference_->settings, settings);
  if (!cached) {
    reference_ = std::make_unique<RefinedReference>(
        RefinedReference{reference.picture, settings, refine_picture(reference, settings)});
  }
  return reference_->modes;
}

Result<RefinedModes> RefineModel::refine_picture(const Reference& reference,
                                                 const RefineSetup& settings) {
  if (!reference.picture) {
    return fail(Errc::refused, "reference", kNoPicture);
  }
  const ReferencePicture& picture = *reference.picture;
  if (std::isnan(picture.gain_db)) return fail(Errc::refused, "reference", kNoGainInDb);
  if (!shows(picture.format, {})) {
    return fail(Errc::refused, "reference",
                "its image was taken in " + std::string(pixel_format_name(picture.format)) +
                    ", and the model does not support colour filters: take a new one");
  }
  const std::vector<Vec2> known_px = known_positions(reference);
  std::vector<SpotFix> spots(known_px.size());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    spots[i].x = float(known_px[i].x);
    spots[i].y = float(known_px[i].y);
  }
  const auto start = bench_->start_of(spots);
  if (!start)
    return fail(Errc::refused, "reference",
                "too few spots of the reference are known to start the fit: take a new reference");
  const RefineCamera camera =
      refine_camera(settings, picture.format, picture.gain_db, picture.frames);
  const auto found = bench_->refiner.refine(picture.mean_dn, camera, *start);
  if (!found) return fail(found.error());
  RefinedModes modes = refined_modes(*found);
  if (const auto doubt = modes.doubt(camera, picture.frames)) {
    return fail(Errc::refused, "reference", *doubt);
  }
  return modes;
}

}  // namespace ovws
