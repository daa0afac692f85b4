#include "daemon/ovwsd/sensor/template_renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(10);
constexpr std::chrono::milliseconds kFramePatience(50);
constexpr int kFrames = 3;  // that tell the noise; the last is measured
constexpr double kDriftWaves = 0.02, kBentWaves = 0.002, kDriftSigmas = 3.0;
constexpr double kMaxResidual = 1.5;                     // standard errors
constexpr double kMoreResidual = 1.3;                    // over that at the operating point
constexpr int kFewRenderings = 8, kManyRenderings = 12;  // from a valid frame, and from another
constexpr std::int64_t kRestNs = 30'000'000;             // between looks at frames
constexpr std::int64_t kGiveUpNs = 3'000'000'000;
constexpr int kMinTracked = 4;  // one spot of so many: else it is dark
constexpr double kCell = 0.5;   // lambda/d: images are compared after binning to this size

/// Whether templates about this frame's wavefront would measure it better: it has drifted away, or
/// the linear templates leave more than noise.
bool is_drifted(const FrameRecord& record) {
  double variance = 0.0;
  for (int k = 0; k < record.mode_count; ++k) {
    variance += std::pow(double(record.sigma_waves[std::size_t(k)]), 2);
  }
  const double expected = kMoreResidual * record.plan->fit->at_point().residual;
  const bool is_bent = record.templates.residual > std::max(kMaxResidual, expected);
  return record.templates.drift_waves >
         std::max(is_bent ? kBentWaves : kDriftWaves, kDriftSigmas * std::sqrt(variance));
}

bool can_be_rendered(const FrameRecord& record) {
  return record.settled && record.settings_known && record.plan->referenced() &&
         kMinTracked * record.tracked >= record.spot_count;
}

/// Modes on the SLM that are not measured.
std::vector<Mode> fixed_modes(const std::vector<Mode>& shown, const std::vector<int>& measured) {
  std::vector<Mode> fixed;
  for (const Mode& mode : shown) {
    const bool is_measured = std::find(measured.begin(), measured.end(), mode.j) != measured.end();
    if (!is_measured) fixed.push_back(mode);
  }
  return fixed;
}

/// What a frame at the operating point reads.
std::vector<double> coefficients_of(const OperatingPoint& point) {
  std::vector<double> waves = point.waves;
  for (std::size_t k = 0; k < waves.size(); ++k) waves[k] -= point.reference_waves[k];
  return waves;
}

constexpr float kFull16 = 65535.0F;

double to_16_bits(PixelFormat format) {
  return double(kFull16) / full_scale_dn(format);
}

/// The mean image in 16 bits; a saturated pixel stays saturated.
Image<std::uint16_t> in_16_bits(const ReferencePicture& picture) {
  Image<std::uint16_t> scaled(picture.mean_dn.width, picture.mean_dn.height);
  const auto scale = float(to_16_bits(picture.format));
  std::transform(picture.mean_dn.pixels.begin(), picture.mean_dn.pixels.end(),
                 scaled.pixels.begin(), [&](float dn) {
                   const float value = scale * dn;
                   return value < kFull16 ? std::uint16_t(std::max(0.0F, value) + 0.5F)
                                          : std::uint16_t(kFull16);
                 });
  return scaled;
}

}  // namespace

/// The model of one sensor and its reference.
struct TemplateRenderer::Model {
  std::uint64_t sensor_epoch = 0;
  int cols = 0, rows = 0;
  std::vector<int> modes_j;
  int estimates = 0;  ///< of each spot
  std::int64_t reference_taken_ns = 0;
  PointModel points;
  std::vector<double> last{};  ///< coefficients of the last operating point

  bool is_for(const FrameCopy& frame, const SensorSnapshot& sensor) const {
    return sensor_epoch == sensor.sensor_epoch && modes_j == sensor.modes_j &&
           estimates == sensor.tracking.estimates && cols == frame.image.width &&
           rows == frame.image.height && reference_taken_ns == sensor.reference->t_taken_ns;
  }
};

TemplateRenderer::TemplateRenderer(const SlmGeometry& slm, FrameBroker& frames,
                                   SensorKeeper& keeper, Events& events)
    : slm_(slm), keeper_(keeper), events_(events), inbox_(frames, can_be_rendered) {}

TemplateRenderer::~TemplateRenderer() = default;

void TemplateRenderer::on_frame(const FrameRecord& record) {
  if (!record.settled) return;
  const bool wanted = record.plan->wants_templates() && can_be_rendered(record) &&
                      (!record.templates.credible || is_drifted(record));
  described_.store(record.templates.credible, std::memory_order_relaxed);
  wanted_.store(wanted, std::memory_order_relaxed);
}

bool TemplateRenderer::do_work() {
  const bool wanted = wanted_.load(std::memory_order_relaxed) && !keeper_.is_held_by_job();
  if (!wanted && described_.load(std::memory_order_relaxed)) succeed();
  if (!wanted || monotonic_ns() < next_ns_) {
    inbox_.forget();
    frames_.clear();
    std::this_thread::sleep_for(kTurn);
    return false;
  }
  const SensorView sensor = keeper_.snapshot();
  const std::int64_t began_ns = monotonic_ns();
  try {
    if (!take_frame(*sensor) || !begin_if_due(frames_.back(), *sensor)) return false;
    report(render(frames_, *sensor), began_ns);
  } catch (const std::bad_alloc&) {
    model_.reset();
    report(
        fail(Errc::refused, "camera.roi", "there is not enough memory for a model of this image"),
        began_ns);
  }
  frames_.clear();
  return true;
}

/// Takes the next frame of the active plan and hologram. Returns whether there are enough of them.
bool TemplateRenderer::take_frame(const SensorSnapshot& sensor) {
  const FrameCopy* const frame = inbox_.next(kFramePatience);
  if (frame == nullptr || !sensor.reference) return false;
  const auto is_other = [&](const FrameCopy& one) {
    return one.plan_id != sensor.plan_id || one.hologram_id != sensor.hologram_id;
  };
  frames_.push_back(copy_of(*frame));
  if (std::any_of(frames_.begin(), frames_.end(), is_other)) frames_.clear();
  return frames_.size() == kFrames;
}

/// Begins to try this frame, unless one failed that looks like it, and was measured by the same
/// plan.
bool TemplateRenderer::begin_if_due(const FrameCopy& frame, const SensorSnapshot& sensor) {
  next_ns_ = monotonic_ns() + kRestNs;
  const SpotModel spots = spot_model(sensor.sensor, sensor.optics, slm_, frame.image.format);
  const int bin = std::max(1, int(kCell * spots.on_plane().lambda_d_px));
  BinnedImage image = binned(frame.image, spots.lit.plane, bin);
  const bool changed = !tried_ || frame.plan_id != tried_plan_id_ || is_other_image(*tried_, image);
  const Doubt doubt = frame.valid ? Doubt::partial : Doubt::blind;
  if (!policy_.is_due(doubt, changed, monotonic_ns())) {
    frames_.clear();
    return false;
  }
  policy_.begin(changed);
  tried_ = std::move(image);
  tried_plan_id_ = frame.plan_id;
  return true;
}

Result<void> TemplateRenderer::render(std::span<const FrameCopy> frames,
                                      const SensorSnapshot& sensor) {
  const FrameCopy& frame = frames.back();
  std::vector<ImageView> images;
  for (const FrameCopy& one : frames) images.push_back(one.image);
  if (traits_of(frame.image.format).filter != ColourFilter::none) {
    return fail(Errc::refused, "pixel_format", "templates need a monochrome pixel format");
  }
  if (!model_ || !model_->is_for(frame, sensor)) {
    model_.reset();
    const std::pair key{sensor.sensor_epoch, sensor.reference->t_taken_ns};
    if (unexplained_ == key) return fail(Errc::refused, "reference", failure_);
    if (auto made = make_model(images, sensor); !made) {
      unexplained_ = key;  // the same reference would fail again
      return made;
    }
  }
  const std::vector<Mode> shown =
      shown_modes(HologramKind::sensor, sensor.aberration, sensor.correction);
  const std::vector<Mode> fixed = fixed_modes(shown, sensor.modes_j);
  Result<void> last = {};
  for (const std::vector<double>& start : starts(frame)) {
    auto fit = model_->points.templates(images, start, fixed,
                                        frame.valid ? kFewRenderings : kManyRenderings);
    if (fit) {
      model_->last = coefficients_of((*fit)->point());
      keeper_.use_templates({sensor.sensor_epoch, sensor.reference->t_taken_ns, std::move(*fit)});
      return {};
    }
    last = fail(fit.error());
  }
  return last;
}

/// Where to look for the wavefront of a frame: where it was measured, with 0 for modes that
/// positions do not tell; else, if it is not valid, where it was last, and at the reference.
std::vector<std::vector<double>> TemplateRenderer::starts(const FrameCopy& frame) const {
  std::vector<std::vector<double>> all;
  if (std::isfinite(frame.coefficients.front())) {
    auto& measured = all.emplace_back(frame.coefficients.begin(), frame.coefficients.end());
    std::replace_if(
        measured.begin(), measured.end(), [](double waves) { return !std::isfinite(waves); }, 0.0);
  }
  if (frame.valid) return all;
  if (!model_->last.empty()) all.push_back(model_->last);
  all.emplace_back(frame.coefficients.size(), 0.0);
  return all;
}

Result<void> TemplateRenderer::make_model(std::span<const ImageView> images,
                                          const SensorSnapshot& sensor) {
  const Reference& reference = *sensor.reference;
  if (!reference.picture) return fail(Errc::refused, "reference", kNoPicture);
  const int cols = images.back().width, rows = images.back().height;
  auto renderer =
      SpotRenderer::make(sensor.sensor, slm_, sensor.optics, cols, rows, sensor.modes_j, {});
  if (!renderer) return fail(renderer.error());
  const auto lattice = make_lattice(sensor.sensor, slm_);
  if (!lattice) return fail(lattice.error());
  const Reconstructor by_model(
      slope_matrix(*lattice, sensor.sensor, sensor.position_modes_j,
                   slope_model(sensor.sensor.charge, sensor.tracking),
                   px_per_cycle(sensor.optics, slm_)),
      sensor.position_modes_j,
      model_spots_px(*lattice, sensor.sensor, slm_, sensor.optics, cols, rows));
  std::vector<SpotFix> spots;
  for (const Vec2 at : known_positions(reference)) spots.push_back({float(at.x), float(at.y)});
  auto scratch = by_model.make_scratch();
  std::vector<float> start(sensor.modes_j.size());
  const std::span<float> leading = std::span(start).first(by_model.modes_j().size());
  if (!by_model.solve(spots, scratch, leading).determined) {
    return fail(Errc::refused, "reference", "too few spots of the reference are known");
  }
  PointModel points(std::move(*renderer), sensor.tracking.estimates);
  const std::vector<double> start_waves(start.begin(), start.end());
  const Image<std::uint16_t> picture = in_16_bits(*reference.picture);
  PixelNoise noise = noise_of(images, points.rendered(std::vector<double>(start.size())));
  const double frames = reference.picture->frames;
  // Of the present frames, whose format may be another than the reference's.
  const double scale = to_16_bits(images.back().format);
  noise.constant_dn2 *= scale * scale / frames;
  noise.per_dn *= scale / frames;
  auto used = points.use_reference(view_of(picture, PixelFormat::mono16), noise, start_waves,
                                   fixed_modes(reference.aberration, sensor.modes_j));
  if (!used) return used;
  model_ = std::make_unique<Model>(Model{sensor.sensor_epoch, cols, rows, sensor.modes_j,
                                         sensor.tracking.estimates, reference.t_taken_ns,
                                         std::move(points)});
  return {};
}

/// Rests after a failure for as long as it took, because images of moving air never look alike, and
/// announces a new one. When nothing has been found for some time, positions have to do.
void TemplateRenderer::report(const Result<void>& rendered, std::int64_t began_ns) {
  const std::int64_t now_ns = monotonic_ns();
  if (rendered) return succeed();
  next_ns_ = now_ns + std::max(kRestNs, now_ns - began_ns);
  policy_.end(now_ns);
  if (failing_since_ns_ == 0) failing_since_ns_ = began_ns;
  if (now_ns - failing_since_ns_ > kGiveUpNs) keeper_.use_templates({});
  if (rendered.error().reason == failure_) return;
  failure_ = rendered.error().reason;
  events_.emit("templates", Severity::warning, "templates do not describe the frames: " + failure_,
               {{"rendered", false}});
}

/// Frames are described by templates, by new ones or by those that there were.
void TemplateRenderer::succeed() {
  next_ns_ = monotonic_ns() + kRestNs;
  policy_.reset();
  failing_since_ns_ = 0;
  if (failure_.empty()) return;
  failure_.clear();
  events_.emit("templates", Severity::info, "frames are measured from all pixels again",
               {{"rendered", true}});
}

}  // namespace ovws
