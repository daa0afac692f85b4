/// Grabs and counts frames, rejects those that the plan cannot measure, and stamps the others.
#include "core/pipeline/ingest.hpp"

#include <cmath>
#include <thread>

#include "core/pipeline/frame_rules.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::microseconds kFrameWait = 20ms;
constexpr std::chrono::microseconds kStarvedWait = 1ms;  // all buffers are lent: poll
constexpr std::chrono::microseconds kIdleWait = 2ms;
constexpr std::uint64_t kRestartGap = 100;

bool fits(const MeasurementPlan& plan, const ImageView& image) {
  return image.width == plan.roi.width && image.height == plan.roi.height &&
         image.format == plan.format;
}

}  // namespace

void Ingest::return_buffers() OVWS_NONBLOCKING {
  deps_.pool.reclaim(deps_.cameras.camera());
}

bool Ingest::serve_camera() OVWS_NONBLOCKING {
  return_buffers();
  if (deps_.cameras.can_serve(deps_.pool.lent())) {
    ++stream_;
    any_frame_ = false;
    arrivals_.reset();
    patterns_.reset();
    msb_alignment_.reset();
    last_frame_mono_ns_.store(0, std::memory_order_relaxed);
    last_sign_mono_ns_.store(0, std::memory_order_relaxed);
    deps_.cameras.serve();
  }
  return deps_.cameras.streaming();
}

Entry* Ingest::run_once(bool& idle) {
  idle = true;
  if (!serve_camera()) {
    deps_.plans.adopt();  // lets old plans retire even without a camera
    std::this_thread::sleep_for(kIdleWait);
    return nullptr;
  }
  Camera& camera = *deps_.cameras.camera();
  const bool starved = deps_.pool.lent() >= camera.buffer_count();
  GrabbedFrame frame;
  switch (camera.grab(frame, starved ? kStarvedWait : kFrameWait)) {
    case GrabStatus::timeout:
      deps_.plans.adopt();
      return nullptr;
    case GrabStatus::incomplete:
      idle = false;
      ++incomplete_since_;
      return reject(Counter::frames_incomplete);
    case GrabStatus::duplicate:
      idle = false;
      return reject(Counter::frames_duplicated);
    case GrabStatus::out_of_order:
      idle = false;
      return reject(Counter::frames_out_of_order);
    case GrabStatus::frame:
      break;
  }
  idle = false;
  return accept(frame);
}

/// Counts a frame that is not measured. Its arrival still shows that the camera sends.
Entry* Ingest::reject(Counter why) OVWS_NONBLOCKING {
  deps_.counters.add(why);
  last_sign_mono_ns_.store(monotonic_ns(), std::memory_order_relaxed);
  return nullptr;
}

/// Whether a frame number is in order. A number far below the last one is a restarted counter.
bool Ingest::is_next(std::uint64_t frame_id) OVWS_NONBLOCKING {
  return !any_frame_ || frame_id > last_frame_id_ || last_frame_id_ - frame_id >= kRestartGap;
}

Entry* Ingest::accept(GrabbedFrame& frame) OVWS_NONBLOCKING {
  if (!is_next(frame.frame_id)) {
    deps_.cameras.camera()->release(frame.slot);
    return reject(frame.frame_id == last_frame_id_ ? Counter::frames_duplicated
                                                   : Counter::frames_out_of_order);
  }
  deps_.counters.add(Counter::frames_grabbed);
  last_frame_mono_ns_.store(frame.t_arrival_mono_ns, std::memory_order_relaxed);
  last_sign_mono_ns_.store(frame.t_arrival_mono_ns, std::memory_order_relaxed);
  count_lost(frame.frame_id);
  align_pixels(frame);
  Entry* const entry = take_entry(frame);
  if (entry == nullptr) {
    deps_.cameras.camera()->release(frame.slot);
    return nullptr;
  }
  stamp(*entry);
  for (std::size_t k = 0; k < entry->plan->beams.size(); ++k) {
    Entry& beam = beam_of(*entry, k);
    static_cast<FrameStamp&>(beam) = *entry;
    beam.plan = entry->plan->beams[k].get();
    beam.measurement = entry->measurement->beams[k].get();
  }
  return entry;
}

void Ingest::align_pixels(GrabbedFrame& frame) OVWS_NONBLOCKING {
  ImageView& image = frame.image;
  if (!frame.justification_known) image.left_justified_bits = msb_alignment_.shift_bits(image);
  if (image.left_justified_bits > 0) deps_.counters.add(Counter::frames_left_justified);
}

Entry* Ingest::take_entry(const GrabbedFrame& frame) OVWS_NONBLOCKING {
  Measurement* const measurement = deps_.plans.adopt();
  if (measurement == nullptr) {
    deps_.counters.add(Counter::frames_unplanned);
    return nullptr;
  }
  if (!fits(measurement->plan, frame.image)) {
    deps_.counters.add(Counter::frames_unexpected);
    return nullptr;
  }
  const bool image_wanted = image_requested_.load(std::memory_order_relaxed);
  Entry* const entry = deps_.pool.take(frame, measurement->plan, image_wanted);
  if (entry == nullptr) {
    deps_.counters.add(Counter::frames_dropped);
    return nullptr;
  }
  if (image_wanted) image_requested_.store(false, std::memory_order_relaxed);
  entry->measurement = measurement;
  entry->stream = stream_;
  deps_.tap.offer(*entry, deps_.cameras.camera()->buffer_count());
  return entry;
}

/// Counts lost frames by gaps in the frame numbers. A number that does not increase is a restarted
/// counter, not a loss.
void Ingest::count_lost(std::uint64_t frame_id) OVWS_NONBLOCKING {
  if (any_frame_ && frame_id > last_frame_id_) {
    const std::uint64_t missing = frame_id - last_frame_id_ - 1;
    if (missing > incomplete_since_) {
      deps_.counters.add(Counter::frames_lost, missing - incomplete_since_);
    }
  }
  any_frame_ = true;
  last_frame_id_ = frame_id;
  incomplete_since_ = 0;
}

void Ingest::stamp(Entry& entry) OVWS_NONBLOCKING {
  deps_.shown.update();
  deps_.settings.update();
  const AppliedSettings& applied = deps_.settings.value();
  if (applied.exposure_us != last_exposure_us_) arrivals_.reset();
  last_exposure_us_ = applied.exposure_us;
  const std::int64_t arrival = entry.frame.t_arrival_mono_ns;
  const std::int64_t undelayed = arrivals_.undelayed_mono_ns(arrival, entry.frame.t_device_ns);
  if (entry.frame.t_device_ns != 0) deps_.arrived.record(arrival - undelayed);
  const SettingsVerdict settings = judge_settings(applied, undelayed);
  entry.settings_known = settings.known;
  entry.gain_db = settings.gain_db;
  entry.gain_raw = settings.gain_raw;
  entry.exposure_us = settings.exposure_us;
  entry.roi = applied.roi;
  entry.transfer_ns = applied.transfer_ns;
  entry.t_exposed_mono_ns = undelayed - applied.transfer_ns / 2;
  const HologramVerdict hologram = judge_hologram(deps_.shown.value(), entry.plan->sensor_epoch,
                                                  settings.exposure_begin_mono_ns, undelayed);
  entry.hologram_id = hologram.hologram_id;
  entry.late = is_late(applied, arrival, undelayed);
  if (entry.late) deps_.counters.add(Counter::frames_late);
  entry.still = hologram.still && !entry.late;
  // After a change of the ROI, positions are meaningless until the plan for the new ROI is active;
  // after a change of the hologram, spots may be lost until the plan that predicts them is active.
  entry.settled = hologram.settled && !entry.late && applied.roi == entry.plan->roi &&
                  hologram.hologram_id <= entry.plan->hologram_id;
  assign_pattern(entry, hologram);
  entry.period_ns = applied.frame_rate_hz > 0.0 ? std::llround(1e9 / applied.frame_rate_hz) : 0;
  if (!entry.settled) deps_.counters.add(Counter::frames_unsettled);
}

/// Finds which pattern of the sequence the frame shows; that pattern's plan measures it. Needs the
/// camera's timestamps, and exposures that one pattern contains.
void Ingest::assign_pattern(Entry& entry, const HologramVerdict& hologram) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *entry.plan;
  entry.pattern = -1;
  if (!hologram.sequence && plan.patterns.empty()) return;
  const bool planned = hologram.sequence && hologram.still && !plan.patterns.empty() &&
                       entry.hologram_id == plan.hologram_id;
  const bool contained =
      entry.settings_known && 1e3 * entry.exposure_us <= double(plan.cycle.period_ns);
  const bool follows = planned && contained && entry.frame.t_device_ns != 0;
  if (!follows || plan.hologram_id != patterns_hologram_id_) patterns_.reset();
  patterns_hologram_id_ = plan.hologram_id;
  const int slot =
      follows ? patterns_.follow(plan.cycle, entry.frame.t_device_ns, light_of(entry.frame.image))
              : PatternFollower::kUncertain;
  entry.settled = entry.settled && slot > 0;
  if (!entry.settled) return;
  entry.pattern = (slot - 1) % int(plan.patterns.size());
  entry.measurement = entry.measurement->patterns[std::size_t(entry.pattern)].get();
  entry.plan = plan.patterns[std::size_t(entry.pattern)].get();
}

}  // namespace ovws
