#include "daemon/ovwsd/refine/refine_model.hpp"

#include <cmath>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/sensor/spots_model.hpp"

namespace ovws {
namespace {

constexpr const char* kNoGainInDb =
    "the camera has no gain in dB, so electrons_per_dn at its gain is unknown: refined needs "
    "another camera";

/// Cache key of the model: everything that the model depends on.
struct Key {
  SensorConfig sensor;
  TrackingSettings tracking;
  int cols = 0, rows = 0;
  LitPixels lit;
  decltype(OpticsConfig::registered) registered;
  decltype(OpticsConfig::centre_px) centre_px;
  std::vector<int> modes_j, position_modes_j;
  std::int64_t reference_taken_ns = 0;  ///< 0: no measured reference
  RefineSetup settings;

  bool operator==(const Key& other) const {
    return sensor == other.sensor && tracking == other.tracking && cols == other.cols &&
           rows == other.rows && lit == other.lit && registered == other.registered &&
           centre_px == other.centre_px && modes_j == other.modes_j &&
           position_modes_j == other.position_modes_j &&
           reference_taken_ns == other.reference_taken_ns && same_fit(settings, other.settings);
  }
};

bool is_measured(const SensorSnapshot& sensor) {
  return sensor.reference && sensor.reference->source == ReferenceSource::measured;
}

Key key_of(const FrameCopy& frame, const SensorSnapshot& sensor, const RefineSetup& settings) {
  return {sensor.sensor,
          sensor.tracking,
          frame.frame.image.width,
          frame.frame.image.height,
          lit_pixels(frame.frame.image.format, sensor.optics.wavelength_nm),
          sensor.optics.registered,
          sensor.optics.centre_px,
          sensor.modes_j,
          sensor.position_modes_j,
          is_measured(sensor) ? sensor.reference->t_taken_ns : 0,
          settings};
}

}  // namespace

bool can_be_refined(const FrameRecord& record) {
  return record.settled && record.pattern < 0 && record.settings_known &&
         (record.valid || !record.plan->referenced());
}

/// Cached model of one sensor, image size and reference. A failure is cached as well, because the
/// same reference would fail again.
struct RefineModel::Bench {
  Key key;
  Result<PointModel> model;
  std::shared_ptr<const FrameFit> templates{};  ///< of the last frame that was rendered
};

RefineModel::RefineModel(const SlmGeometry& slm) : slm_(slm) {}
RefineModel::~RefineModel() = default;

RefinedFrame RefineModel::refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                                 const RefineSetup& settings) {
  RefinedFrame out;
  out.against_reference = is_measured(sensor);
  const auto refused = [&out](std::string why) {
    out.refusal = std::move(why);
    return out;
  };
  if (std::isnan(frame.gain_db)) return refused(kNoGainInDb);
  if (auto made = make_bench(frame, sensor, settings); !made) return refused(made.error().reason);
  if (!bench_->model) {
    const char* const of = out.against_reference ? "the reference cannot be refined: " : "";
    return refused(of + bench_->model.error().reason);
  }
  std::vector<std::vector<double>> starts;
  const auto measured = frame.all_coefficients();
  starts.emplace_back(measured.begin(), measured.end());
  if (!out.against_reference) {
    auto absolute = modes_against_model(sensor, slm_, frame.frame.image.width,
                                        frame.frame.image.height, frame.spots);
    if (!absolute) {
      return refused(
          "too few spots were found to start the fit: check the exposure and camera.roi");
    }
    starts.front() = std::move(*absolute);
  }
  const RefineCamera camera = refine_camera(settings, frame.frame.image.format, frame.gain_db);
  const std::vector<Mode> shown =
      shown_modes(HologramKind::sensor, sensor.aberration, sensor.correction);
  const std::int64_t begun_ns = monotonic_ns();
  const std::vector<Mode> fixed = fixed_modes(shown, sensor.modes_j);
  auto found = out.against_reference
                   ? ovws::refine(*bench_->model, frame.frame.image, camera, starts, fixed,
                                  bench_->templates)
                   : refine_absolute(*bench_->model, frame.frame.image, camera, starts, fixed);
  out.duration_ms = 1e-6 * double(monotonic_ns() - begun_ns);
  if (!found) return refused(found.error().reason);
  out.modes = std::move(*found);
  out.refusal = out.modes->doubt(camera).value_or("");
  return out;
}

void RefineModel::forget_frames() {
  if (bench_) bench_->templates.reset();
}

Result<void> RefineModel::make_bench(const FrameCopy& frame, const SensorSnapshot& sensor,
                                     const RefineSetup& settings) {
  Key key = key_of(frame, sensor, settings);
  if (bench_ && bench_->key == key) return {};
  bench_.reset();
  const ReferenceImage* const picture =
      key.reference_taken_ns != 0 ? sensor.reference->picture.get() : nullptr;
  if (picture != nullptr && std::isnan(picture->gain_db)) {
    return fail(Errc::refused, "reference", kNoGainInDb);
  }
  auto model = rendered_model(sensor, slm_, frame.frame.image, [&](PointModel&) {
    return std::pair(pixel_noise(refine_camera(settings, picture->format, picture->gain_db)),
                     picture->format);
  });
  bench_ = std::make_unique<Bench>(Bench{std::move(key), std::move(model), nullptr});
  return {};
}

}  // namespace ovws
