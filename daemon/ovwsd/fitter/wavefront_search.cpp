#include "daemon/ovwsd/fitter/wavefront_search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/fitter/spots_model.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kPollInterval(10);
constexpr std::chrono::milliseconds kFramePatience(50);
constexpr int kFrames = 3;  // frames for a search: two give the noise, the last is measured
constexpr int kFewRenderings = 8, kManyRenderings = 12;  // per start: valid frame; invalid frame
// Renderings for an unchanged image after two failed searches: finds wavefronts of 2 waves RMS.
constexpr int kMostRenderings = 40;
constexpr std::int64_t kRestNs = 30'000'000;  // minimum pause between two search attempts
constexpr std::int64_t kLookAgainNs = 1'000'000'000;
constexpr std::int64_t kLostNs = 50'000'000;  // before another tracker's spots count as lost
constexpr double kFlatWaves = 0.1;            // RMS of a wavefront that every tracker measures
constexpr std::int64_t kTryAgainNs = 10'000'000'000;  // a failed model: new frames give new noise
constexpr double kCell = 0.5;  // lambda/d: images are compared after binning to this size

TemplateDrift drift_of(const FrameRecord& record) {
  double variance = -std::pow(record.templates.bent_waves, 2);  // drift adds to sigma_waves
  for (int k = 0; k < record.mode_count; ++k) {
    variance += std::pow(double(record.sigma_waves[std::size_t(k)]), 2);
  }
  const FrameFit& fit = *record.plan->fit;
  return {.drift_waves = record.templates.drift_waves,
          .sigma_waves = std::sqrt(std::max(variance, 0.0)),
          .residual = record.templates.residual,
          .point_residual = fit.at_point().residual,
          .in_air = fit.point().higher_waves > 0.0};
}

bool can_be_rendered(const FrameRecord& record) {
  return record.settled && record.plan->referenced();
}

/// Coefficients of a frame at the operating point, relative to the reference.
std::vector<double> coefficients_of(const OperatingPoint& point) {
  std::vector<double> waves = point.waves;
  for (std::size_t k = 0; k < waves.size(); ++k) waves[k] -= point.reference_waves[k];
  return waves;
}

}  // namespace

/// Model of one sensor and its reference. A failure to make the model is kept for kTryAgainNs,
/// because the unchanged reference would fail again.
struct WavefrontSearch::Model {
  ModelKey key;
  TemplatesKey made_for{};
  Result<SpotsModel> spots = fail(Errc::refused, "reference", "");
  std::int64_t failed_until_ns = 0;  ///< time to try again with other frames
  std::vector<double> last{};        ///< coefficients of the last rendered operating point
  double gain_db = 0.0, gain_raw = kUnknownGain, exposure_us = 0.0;  ///< of the last frame

  void use_settings_of(const FrameCopy& frame) {
    const bool same = same_number(frame.gain_db, gain_db) &&
                      same_number(frame.gain_raw, gain_raw) && frame.exposure_us == exposure_us;
    if (!same && spots) spots->forget_noise();
    gain_db = frame.gain_db, gain_raw = frame.gain_raw, exposure_us = frame.exposure_us;
  }
  bool has_failed() const { return !spots && monotonic_ns() < failed_until_ns; }
  void set_failed(Error why) {
    spots = fail(std::move(why));
    failed_until_ns = monotonic_ns() + kTryAgainNs;
  }
};

WavefrontSearch::WavefrontSearch(const Config& config, FrameTaps& frames,
                                 const ImageBrightness& brightness, SensorKeeper& keeper,
                                 Events& events)
    : slm_(config.slm.geometry),
      keeper_(keeper),
      events_(events),
      inbox_(frames, can_be_rendered),
      validity_(config.beams, brightness),
      tap_(frames, FrameTap::Needs::numbers, FrameTap::kEndless, [this](const FrameRecord& record) {
        on_frame(record);
        return true;
      }) {}

WavefrontSearch::~WavefrontSearch() = default;

std::optional<StatusMessage::SensorPart::Invalid> WavefrontSearch::why_invalid(
    std::size_t source) const {
  const SensorView sensor = keeper_.snapshot();
  if (source == 0 && !sensor->obstacle.reason.empty()) return sensor->obstacle;
  if (source == 0 && !sensor->reference) return std::nullopt;
  return validity_.why_invalid(source, monotonic_ns(), utc_ns());
}

/// Publish thread: sees every frame.
void WavefrontSearch::on_frame(const FrameRecord& record) {
  const bool searched = record.settled && may_search(record);
  const bool uncertain = !record.plan->patterns.empty();  // of a sequence, never settled
  if (record.settled || uncertain) {
    const bool described = record.settled && record.templates.credible;
    described_.store(described, std::memory_order_relaxed);
    wanted_.store(
        searched && can_be_rendered(record) && (!described || is_drifted(drift_of(record))),
        std::memory_order_relaxed);
  }
  if (record.settled && record.plan->referenced() && !record.templates.credible) {
    undescribed_.fetch_add(1, std::memory_order_relaxed);
    if (record.valid || record.unconfirmed) explained_.fetch_add(1, std::memory_order_relaxed);
  }
  validity_.on_frame(record, searched, monotonic_ns());
}

/// Whether the wavefront of frames like this one may be searched. For another tracker than `fit`
/// also decides whether it can do without templates again.
bool WavefrontSearch::may_search(const FrameRecord& record) {
  const MeasurementPlan& plan = *record.plan;
  const std::int64_t now_ns = monotonic_ns();
  if (record.valid) t_valid_ns_ = now_ns;
  const bool is_flat =
      record.valid && (!record.templates.credible || record.reconstruction.rms_waves < kFlatWaves);
  is_flat_.store(!plan.wants_templates() && plan.fit != nullptr && is_flat,
                 std::memory_order_relaxed);
  if (plan.wants_templates()) return true;
  return plan.may_use_templates() && keeper_.holder() == Holder::loop && !is_flat &&
         (plan.fit != nullptr || now_ns - t_valid_ns_ > kLostNs);
}

bool WavefrontSearch::do_work() {
  validity_.announce(events_, monotonic_ns());
  const bool asked = wanted_.load(std::memory_order_relaxed) || looks_for_calibration();
  const bool wanted = asked && keeper_.holder() != Holder::job;
  if (!wanted) {
    giving_up_.reset();
    undescribed_ = explained_ = 0;  // a job's frames may be dark
  }
  if (!wanted && described_.load(std::memory_order_relaxed)) succeed();
  if (is_flat_.load(std::memory_order_relaxed)) {
    if (model_) use_templates(nullptr);
    return rest();
  }
  if (!wanted || monotonic_ns() < next_ns_) return rest();
  const SensorView sensor = keeper_.snapshot();
  const std::int64_t began_ns = monotonic_ns();
  try {
    if (!take_frame(*sensor) || !begin_if_due(frames_.back(), *sensor)) return false;
    report(render(frames_, *sensor), began_ns);
  } catch (const std::bad_alloc&) {
    const Error why{Errc::refused, "camera.roi",
                    "there is not enough memory for a model of this image"};
    if (model_) model_->spots = fail(why);  // retry: memory may be free then
    report(fail(why), began_ns);
  }
  frames_.clear();
  return true;
}

bool WavefrontSearch::rest() {
  inbox_.forget();
  frames_.clear();
  std::this_thread::sleep_for(kPollInterval);
  return false;
}

/// Replaces the active templates. Null: by none, so that the tracker measures the frames.
void WavefrontSearch::use_templates(std::shared_ptr<const FrameFit> fit, bool given_up) {
  keeper_.use_templates({model_->made_for, std::move(fit), given_up});
}

/// Takes the next frame of the active sensor. Returns whether there are kFrames successive frames.
/// In a closed loop each frame may have another hologram: frames are used together as long as the
/// holograms differ in measured modes only.
bool WavefrontSearch::take_frame(const SensorSnapshot& sensor) {
  auto frame = inbox_.next(kFramePatience);
  if (!frame || !sensor.reference) return false;
  const bool any_hologram = fixed_modes(sensor).empty();
  const auto is_other = [&](const FrameCopy& one) {
    return one.sensor_epoch != sensor.sensor_epoch ||
           !(any_hologram || one.hologram_id == sensor.hologram_id);
  };
  frames_.push_back(std::move(*frame));
  const ImageView &first = frames_.front().frame.image, &last = frames_.back().frame.image;
  const bool same_image =
      first.width == last.width && first.height == last.height && first.format == last.format;
  if (!same_image || std::any_of(frames_.begin(), frames_.end(), is_other)) frames_.clear();
  return frames_.size() == kFrames;
}

/// Begins a search of this frame if SearchPolicy allows one. An image counts as unchanged if it
/// looks like the image searched last and has the plan of that image.
bool WavefrontSearch::begin_if_due(const FrameCopy& frame, const SensorSnapshot& sensor) {
  next_ns_ = monotonic_ns() + kRestNs;
  const SpotModel spots = spot_model(sensor.sensor, sensor.optics, slm_, frame.frame.image.format);
  const int bin = std::max(1, int(kCell * spots.on_plane().lambda_d_px));
  BinnedImage image = binned(frame.frame.image, spots.lit.plane, bin);
  const bool changed = !tried_ || frame.plan_id != tried_plan_id_ || is_other_image(*tried_, image);
  const Doubt doubt = frame.valid ? Doubt::partial : Doubt::blind;
  if (!policy_.is_due(doubt, changed, monotonic_ns())) {
    frames_.clear();
    return false;
  }
  policy_.begin(changed);
  validity_.search_begins();
  tried_ = std::move(image);
  tried_plan_id_ = frame.plan_id;
  return true;
}

/// Whether to try the calibration's measured templates, which are more accurate than the active
/// rendered templates. The wavefront may have come near the calibration's wavefront.
bool WavefrontSearch::looks_for_calibration() const {
  const bool described = described_.load(std::memory_order_relaxed);
  return described && !measured_ && model_ && model_->spots && model_->spots->has_measured() &&
         monotonic_ns() > look_again_ns_;
}

Result<void> WavefrontSearch::render(std::span<const FrameCopy> frames,
                                     const SensorSnapshot& sensor) {
  const FrameCopy& frame = frames.back();
  std::vector<ImageView> images;
  for (const FrameCopy& one : frames) images.push_back(one.frame.image);
  const ModelKey key(frame, sensor);
  const bool same = model_ && model_->key == key;
  const bool is_other = !same || !(model_->made_for == sensor.templates_for);
  if (is_other) {
    giving_up_.reset();
    const bool keep = same && model_->spots && model_->spots->has_rendered();
    if (!keep) model_ = std::make_unique<Model>(Model{key});
    model_->made_for = sensor.templates_for;
  }
  if (is_other || (!model_->spots && !model_->has_failed())) make_model(images, sensor);
  if (!model_->spots) return fail(model_->spots.error());
  look_again_ns_ = monotonic_ns() + kLookAgainNs;
  model_->use_settings_of(frame);
  auto fit = found(images, frame, sensor);
  if (!fit) return fail(fit.error());
  if (*fit == nullptr) return {};
  measured_ = (*fit)->point().measured;
  if (!measured_) model_->last = coefficients_of((*fit)->point());
  use_templates(std::move(*fit));
  return {};
}

/// Finds templates for the frame. Null: keep the active templates.
Result<std::shared_ptr<const FrameFit>> WavefrontSearch::found(std::span<const ImageView> images,
                                                               const FrameCopy& frame,
                                                               const SensorSnapshot& sensor) {
  if (!wanted_.load(std::memory_order_relaxed)) return model_->spots->measured_near(images);
  auto fit = model_->spots->templates(images, starts(frame), fixed_modes(sensor),
                                      frame.valid           ? kFewRenderings
                                      : policy_.tries() > 1 ? kMostRenderings
                                                            : kManyRenderings);
  const bool described = described_.load(std::memory_order_relaxed);
  const bool same = fit && (*fit)->point().measured && measured_ && described;
  if (!same) return fit;
  next_ns_ = monotonic_ns() + kLookAgainNs;  // the calibration's again: wait before the next try
  return nullptr;
}

/// Start points of the search, as coefficients. For a valid frame: its coefficients. For an invalid
/// frame: first the reference (all 0), from which most wavefronts are found; then its coefficients,
/// if any, with 0 for modes that positions do not determine; then the last found ones.
std::vector<std::vector<double>> WavefrontSearch::starts(const FrameCopy& frame) const {
  std::vector<std::vector<double>> all;
  const auto coefficients = frame.all_coefficients();
  if (std::isfinite(coefficients.front())) {
    auto& measured = all.emplace_back(coefficients.begin(), coefficients.end());
    std::replace_if(
        measured.begin(), measured.end(), [](double waves) { return !std::isfinite(waves); }, 0.0);
  }
  if (frame.valid) return all;
  all.emplace(all.begin(), coefficients.size(), 0.0);
  if (!model_->last.empty()) all.push_back(model_->last);
  return all;
}

/// Makes the model for its key. If there is one already, only its calibration is out of date.
void WavefrontSearch::make_model(std::span<const ImageView> images, const SensorSnapshot& sensor) {
  measured_ = false;
  if (!model_->spots) {
    model_->spots = SpotsModel::make(sensor, slm_, images);
  } else if (auto used = model_->spots->use_calibration(sensor, images); !used) {
    model_->spots = fail(used.error());
  }
  if (!model_->spots) return model_->set_failed(model_->spots.error());
  const std::string& why = model_->spots->unmeasured();
  if (why.empty()) return;
  events_.emit("templates", Severity::warning, "templates of the calibration are not used: " + why,
               {{"rendered", true}});
}

/// Handles the result of a search. After a failure, pauses for as long as the search took, because
/// images of moving air always count as changed, and publishes a new reason. Tells the keeper when
/// spot positions count instead of templates, and when they no longer do.
void WavefrontSearch::report(const Result<void>& rendered, std::int64_t began_ns) {
  const std::int64_t now_ns = monotonic_ns();
  if (rendered) {
    found_ns_.store(now_ns, std::memory_order_relaxed);
    return succeed();
  }
  next_ns_ = now_ns + std::max(kRestNs, now_ns - began_ns);
  policy_.end(now_ns);
  validity_.search_failed(policy_.next_ns());
  const bool given_up = keeper_.snapshot()->given_up;
  const int frames = undescribed_.exchange(0), explained = explained_.exchange(0);
  const bool fails = giving_up_.failed(given_up, began_ns, now_ns, frames, explained);
  const bool gives_up = fails || (model_ && model_->has_failed());
  if (model_ && gives_up != given_up && !described_.load(std::memory_order_relaxed)) {
    use_templates(nullptr, gives_up);
  }
  if (rendered.error().reason == failure_) return;
  failure_ = rendered.error().reason;
  events_.emit("templates", Severity::warning, "templates do not describe the frames: " + failure_,
               {{"rendered", false}});
}

/// Resets the search when templates describe the frames, whether new templates or the active ones.
void WavefrontSearch::succeed() {
  next_ns_ = std::max(next_ns_, monotonic_ns() + kRestNs);
  policy_.reset();
  validity_.search_succeeded();
  giving_up_.reset();
  if (failure_.empty()) return;
  failure_.clear();
  events_.emit("templates", Severity::info, "frames are measured from all pixels again",
               {{"rendered", true}});
}

}  // namespace ovws
