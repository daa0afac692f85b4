#include "daemon/ovwsd/fitter/refine_model.hpp"

#include <cmath>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/fitter/spots_model.hpp"

namespace ovws {
namespace {

constexpr const char* kNoGainInDb =
    "the camera has no gain in dB, so electrons_per_dn at its gain is unknown: refined needs "
    "another camera";

bool is_measured(const SensorSnapshot& sensor) {
  return sensor.reference && sensor.reference->source == ReferenceSource::measured;
}

}  // namespace

bool can_be_refined(const FrameRecord& record) {
  return record.settled && record.pattern < 0 && record.settings_known &&
         (record.valid || !record.plan->referenced());
}

/// Cached model. A failure is cached as well, because the same reference would fail again.
struct RefineModel::Bench {
  ModelKey key;
  RefineSetup settings;
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
  const std::int64_t begun_ns = monotonic_ns();
  const std::vector<Mode> fixed = fixed_modes(sensor);
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
  ModelKey key(frame, sensor);
  if (bench_ && bench_->key == key && same_fit(bench_->settings, settings)) return {};
  bench_.reset();
  const ReferenceImage* const picture =
      is_measured(sensor) ? sensor.reference->picture.get() : nullptr;
  if (picture != nullptr && std::isnan(picture->gain_db)) {
    return fail(Errc::refused, "reference", kNoGainInDb);
  }
  auto model = rendered_model(sensor, slm_, frame.frame.image, [&](PointModel&) {
    return std::pair(pixel_noise(refine_camera(settings, picture->format, picture->gain_db)),
                     picture->format);
  });
  bench_ = std::make_unique<Bench>(Bench{std::move(key), settings, std::move(model)});
  return {};
}

}  // namespace ovws
