/// Replay of a recording. A frame's measurement depends on its pixels, its plan, the start
/// positions of its spots, and the known state of hologram and camera settings. The file has all
/// this data, so the replay is exact.
#include "daemon/ovwsd/record/player.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>

#include "core/pipeline/pipeline.hpp"
#include "daemon/ovwsd/record/recorded_plan.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kLongAgo = std::numeric_limits<std::int64_t>::min() / 4;
constexpr int kPatienceUs = 5'000'000;
constexpr std::size_t kRefineBlock = 100;  // positions

/// A camera that delivers one recorded frame per call of `give`.
class SteppedCamera final : public Camera {
 public:
  explicit SteppedCamera(RecordingReader& reader)
      : header_(reader.header()), pixels_(reader.image_bytes()) {}

  std::span<std::byte> pixels() { return pixels_; }
  void give(const RecordedFrame& frame) {
    const std::lock_guard lock(mutex_);
    next_ = frame;
    given_.notify_one();
  }

  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override { return CameraLimits{}; }
  Result<CameraSettings> apply(const CameraSettings& wanted) override { return wanted; }
  Result<void> start() override { return {}; }
  void stop() override {}
  bool alive() const override { return true; }
  int buffer_count() const override { return 1; }
  void release(int) OVWS_NONBLOCKING override {}

  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) override {
    std::unique_lock lock(mutex_);
    if (!given_.wait_for(lock, timeout, [this] { return next_.has_value(); })) {
      return GrabStatus::timeout;
    }
    out.image = {pixels_.data(), header_.width,
                 header_.height, std::ptrdiff_t(row_bytes(header_.format, header_.width)),
                 header_.format, next_->left_justified_bits};
    out.justification_known = true;
    // Frames are renumbered from 1: a reopened camera may have restarted its numbers from 0.
    out.frame_id = ++count_;
    out.t_device_ns = 0;
    out.t_arrival_ns = next_->t_arrival_ns;
    out.t_arrival_mono_ns = next_->t_arrival_mono_ns;
    out.slot = 0;
    next_.reset();
    return GrabStatus::frame;
  }

 private:
  const RecordingHeader& header_;
  CameraInfo info_;
  std::vector<std::byte> pixels_;
  std::mutex mutex_;
  std::condition_variable given_;
  std::optional<RecordedFrame> next_;
  std::uint64_t count_ = 0;
};

template <typename Number>
bool same_bits(Number a, Number b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

bool same_spot(const SpotFix& now, const RecordedSpot& then) {
  return same_bits(now.x, then.x) && same_bits(now.y, then.y) && same_bits(now.peak, then.peak) &&
         same_bits(now.quality, then.quality) && same_bits(now.level, then.level) &&
         same_bits(now.noise, then.noise);
}

bool same_spots(const FrameRecord& now, std::span<const RecordedSpot> then) {
  return now.spot_count == int(then.size()) &&
         std::equal(then.begin(), then.end(), now.spots.begin(),
                    [](const RecordedSpot& a, const SpotFix& b) { return same_spot(b, a); });
}

/// Whether the further light sources have the same spots; `then` holds those of all.
bool same_beams(const FrameRecord& now, std::span<const RecordedSpot> then, unsigned searched) {
  for (const FrameRecord* const beam : now.beams()) {
    const auto spots = std::min(std::size_t(beam->spot_count), then.size());
    searched >>= 1U;
    if (beam->searched != ((searched & 1U) != 0)) return false;
    if (!same_spots(*beam, then.first(spots))) return false;
    then = then.subspan(spots);
  }
  return true;
}

bool same_verdicts(const FrameRecord& now, const RecordedFrame& then) {
  return now.still == (then.still != 0) && now.settled == (then.settled != 0) &&
         now.searched == ((then.searched & 1U) != 0) && now.explained == (then.explained != 0) &&
         now.reconstruction.determined == (then.determined != 0) &&
         now.valid == (then.valid != 0) && now.tracked == int(then.tracked) &&
         same_bits(now.saturated_fraction, then.saturated) &&
         same_bits(now.reconstruction.fit_residual_px, then.fit_residual_px) &&
         same_bits(now.reconstruction.rms_waves, then.rms_waves);
}

/// Why the plan cannot measure images of this recording; empty if it can.
std::string other_image(const RecordingHeader& header, const MeasurementPlan& plan) {
  if (header.width == plan.roi.width && header.height == plan.roi.height &&
      header.format == plan.format) {
    return {};
  }
  return fmt::format("its plan is for an image of {} x {}, {}; the recording's are {} x {}, {}",
                     plan.roi.width, plan.roi.height, pixel_format_name(plan.format), header.width,
                     header.height, pixel_format_name(header.format));
}

bool same(const FrameRecord& now, const RecordedFrame& then, std::span<const RecordedSpot> spots,
          std::span<const float> coefficients, std::span<const float> sigma_waves) {
  return now.mode_count == int(coefficients.size()) && same_verdicts(now, then) &&
         same_spots(now, spots) &&
         std::equal(coefficients.begin(), coefficients.end(), now.coefficients.begin(),
                    same_bits<float>) &&
         std::equal(sigma_waves.begin(), sigma_waves.end(), now.sigma_waves.begin(),
                    same_bits<float>);
}

}  // namespace

struct Player::Impl {
  std::unique_ptr<RecordingReader> reader;
  RecordedPlans plans;
  SteppedCamera camera;
  Counters counters;
  LatestValue<ShownHologram> shown;
  LatestValue<AppliedSettings> settings;
  Pipeline pipeline{{.records = 8, .beams = kMaxBeams}, {counters, shown, settings}};
  ThreadPlan threads{RealtimePolicy::ignore};
  /// Plans by their number in the replay.
  std::map<std::uint64_t, std::unique_ptr<MeasurementPlan>> made;
  const MeasurementPlan* plan = nullptr;  ///< plan in use
  std::uint64_t plan_id = 0;              ///< number of `plan` in the recording
  std::uint64_t next_plan_id = 1;
  std::string why_no_plan;
  std::size_t next = 0, end;
  std::size_t first = 0;  ///< frames before it are not selected
  RefineSetup refine_setup;
  std::optional<RefineModel> refine_model;  ///< none: frames are not refined

  Impl(std::unique_ptr<RecordingReader> opened, RecordedPlans found)
      : reader(std::move(opened)),
        plans(std::move(found)),
        camera(*reader),
        end(reader->frames().size()) {}

  void use_plan(std::uint64_t id);
  void set_conditions(const RecordedFrame& frame);
  Result<void> measure(PlayedFrame& frame);
  RefinedFrame refine(const FrameRecord& record);
  Result<PlayedFrame> step();
};

/// Gives a recorded plan to the pipeline under a new number. The pipeline requires rising plan
/// numbers, but a recording can return to an earlier plan.
void Player::Impl::use_plan(std::uint64_t id) {
  if (plan != nullptr && id == plan_id) return;
  auto built = plans.make(id);
  plan_id = id;
  plan = nullptr;
  why_no_plan.clear();
  if (!built) {
    why_no_plan = built.error().reason;
    return;
  }
  (*built)->id = next_plan_id++;
  pipeline.use_plan(built->get());
  plan = built->get();
  made[plan->id] = std::move(*built);
  std::erase_if(made, [&](const auto& one) {
    return one.first < pipeline.oldest_plan_in_use() && one.second.get() != plan;
  });
}

/// Sets the hologram and camera settings so that the frame path reaches the recorded verdicts
/// (`still`, `settled`, `settings_known`).
void Player::Impl::set_conditions(const RecordedFrame& frame) {
  AppliedSettings applied;
  applied.gain_db = applied.previous_gain_db = frame.gain_db;
  applied.gain_raw = applied.previous_gain_raw = frame.gain_raw;
  applied.exposure_us = applied.previous_exposure_us = frame.exposure_us;
  applied.roi = plan->roi;
  applied.t_previous_end_mono_ns = ShownHologram::kNever;
  applied.t_write_begin_mono_ns = kLongAgo;
  applied.t_write_end_mono_ns = frame.settings_known != 0 ? kLongAgo : ShownHologram::kNever;
  settings.write(applied);
  ShownHologram now;
  now.healthy = true;
  now.current.hologram_id = frame.hologram_id;
  now.current.sensor_epoch = frame.settled != 0 ? plan->sensor_epoch : 0;
  now.current.t_begin_mono_ns = kLongAgo;
  now.current.t_settled_mono_ns = frame.still != 0 ? kLongAgo : ShownHologram::kNever;
  shown.write(now);
}

Result<void> Player::Impl::measure(PlayedFrame& frame) {
  auto spots = reader->spots(frame.recorded);
  if (!spots) return fail(spots.error());
  const auto coefficients = reader->coefficients(frame.recorded);
  if (!coefficients) return fail(coefficients.error());
  const auto sigma_waves = reader->sigma_waves(frame.recorded);
  if (!sigma_waves) return fail(sigma_waves.error());
  if (auto read = reader->picture(frame.recorded, camera.pixels()); !read) return read;
  if (spots->size() != plan->predicted_px.size()) {
    frame.reason = "its number of spots is not its plan's";
    return {};
  }
  std::vector<RecordedSpot> beam_spots;
  if (!plan->beams.empty()) {
    auto read = reader->beam_spots(frame.recorded, plan->beams.size() * spots->size());
    if (!read) return fail(read.error());
    beam_spots = std::move(*read);
  }
  if (const std::string other = other_image(reader->header(), *plan); !other.empty()) {
    frame.reason = other;  // the pipeline would drop the frame, and next() would time out
    return {};
  }
  std::vector<SpotStart> starts;
  for (const auto* const all : {&*spots, &beam_spots}) {
    for (const RecordedSpot& spot : *all) {
      starts.push_back({{spot.start_x, spot.start_y}, spot.fresh != 0});
    }
  }
  // `explained` stands for "the frame before follows" (FrameRecord::follows), which is not recorded
  // and matters only if positions measure the frame, its plan has or awaits templates, and the
  // frame is not at its reference: then it is explained only if the frame before follows.
  pipeline.resume(*plan, starts, frame.recorded.explained != 0, frame.recorded.searched);
  set_conditions(frame.recorded);
  camera.give(frame.recorded);
  FrameRecord* const record = pipeline.next(kPatienceUs);
  if (record == nullptr) {
    frame.reason = "the pipeline did not measure its image";
    return {};
  }
  frame.replayed = true;
  frame.same = same(*record, frame.recorded, *spots, *coefficients, *sigma_waves) &&
               same_beams(*record, beam_spots, frame.recorded.searched);
  frame.valid = record->valid;
  frame.modes_j = plan->modes_j;
  frame.coefficients.assign(record->coefficients.begin(),
                            record->coefficients.begin() + record->mode_count);
  frame.sigma_waves.assign(record->sigma_waves.begin(),
                           record->sigma_waves.begin() + record->mode_count);
  if (refine_model && can_be_refined(*record)) frame.refined = refine(*record);
  pipeline.release(record);
  return {};
}

RefinedFrame Player::Impl::refine(const FrameRecord& record) {
  const auto sensor = plans.sensor(plan_id, *plan);
  if (!sensor) {
    RefinedFrame refused;
    refused.refusal = sensor.error().reason;
    return refused;
  }
  const FrameCopy frame = copy_of(record);
  return refine_model->refine(frame, **sensor, in_format(refine_setup, frame.frame.image.format));
}

/// Replays the frame at `next`.
Result<PlayedFrame> Player::Impl::step() {
  if (refine_model && next % kRefineBlock == 0) refine_model->forget_frames();
  PlayedFrame frame;
  frame.recorded = reader->frames()[next++];
  if (frame.recorded.picture < 0) {
    frame.reason = "it was recorded without its image";
  } else {
    use_plan(frame.recorded.plan_id);
    if (plan == nullptr) frame.reason = why_no_plan;
  }
  if (frame.reason.empty()) {
    if (auto measured = measure(frame); !measured) return fail(measured.error());
  }
  return frame;
}

Player::Player(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Player::~Player() {
  (void)impl_->pipeline.detach();
  (void)impl_->threads.stop_all(kPatienceUs * 1e-6);
}

Result<std::unique_ptr<Player>> Player::open(const std::string& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) return fail(reader.error());
  auto plans = RecordedPlans::of(**reader);
  if (!plans) return fail(plans.error());
  auto impl = std::make_unique<Impl>(std::move(*reader), std::move(*plans));
  auto started = impl->threads.start(ThreadRole::replay, impl->pipeline.acquisition());
  if (!started) return fail(started.error());
  auto attached = impl->pipeline.attach(impl->camera);
  std::unique_ptr<Player> player(new Player(std::move(impl)));
  if (!attached) return fail(attached.error());
  return player;
}

RecordingReader& Player::reader() {
  return *impl_->reader;
}

Result<Config> Player::configuration() const {
  return impl_->plans.configuration();
}

void Player::select(std::size_t begin, std::size_t end) {
  impl_->end = std::min(end, impl_->reader->frames().size());
  impl_->first = impl_->next = std::min(begin, impl_->end);
  if (impl_->refine_model) impl_->next -= impl_->next % kRefineBlock;
}

void Player::refine(const RefineSetup& setup, const SlmGeometry& slm) {
  impl_->refine_setup = setup;
  impl_->refine_model.emplace(slm);
  impl_->next -= impl_->next % kRefineBlock;
}

Result<std::optional<PlayedFrame>> Player::step() {
  if (impl_->first == impl_->end) return std::nullopt;
  while (impl_->next < impl_->first) {
    if (auto before = impl_->step(); !before) return fail(before.error());
  }
  if (impl_->next == impl_->end) return std::nullopt;
  return impl_->step();
}

}  // namespace ovws
