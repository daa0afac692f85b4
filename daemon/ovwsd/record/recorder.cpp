#include "daemon/ovwsd/record/recorder.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/tables/camera.hpp"

namespace ovws {
namespace {

constexpr int kTurnUs = 20'000;
constexpr std::chrono::milliseconds kIdle{50};
constexpr std::int64_t kFlushNs = 250'000'000;
// Limits of remembered plans, each of which may hold a reference's image. While nothing is
// recorded, only plans of frames in flight are kept. A recording keeps the plans of all frames that
// wait for the disk.
constexpr std::size_t kIdleFacts = 4;
constexpr std::size_t kMaxFacts = FrameStore::kMaxFrames + kIdleFacts;

constexpr const char* kGone =
    "its file was removed or moved while it was written; do so only after record.stop";
constexpr std::int64_t kStopRestNs = 120'000'000'000;  // to write remaining frames at a stop
constexpr const char* kTooSlow =
    "the disk was too slow to write the last frames: use a faster disk, or a smaller camera.roi";
constexpr const char* kDiskFull = "the disk is full: less than 64 MiB are left; delete some files";

nlohmann::json camera_content(const CameraSettings& settings,
                              const std::optional<CameraInfo>& info) {
  return {{"settings", to_json(settings)}, {"info", info ? to_json(*info) : nlohmann::json()}};
}

RecordingHeader header_of(const Recorder::Begin& begin) {
  RecordingHeader header;
  header.t_begin_ns = utc_ns();
  header.program = begin.program;
  header.format = begin.camera.pixel_format;
  const CameraInfo info = begin.camera_info.value_or(CameraInfo{});
  header.vendor = info.vendor;
  header.model = info.model;
  header.serial = info.serial;
  header.frame_rate_hz = begin.camera.frame_rate_hz;
  header.x = begin.camera.roi.x;
  header.y = begin.camera.roi.y;
  header.width = begin.camera.roi.width;
  header.height = begin.camera.roi.height;
  header.pictures_every = begin.asked.pictures_every;
  return header;
}

Result<std::size_t> image_bytes_of(const CameraSettings& camera) {
  const std::size_t bytes =
      row_bytes(camera.pixel_format, camera.roi.width) * std::size_t(camera.roi.height);
  if (bytes <= kMaxRecordedImageBytes) return bytes;
  return fail(Errc::refused, "",
              fmt::format("an image has {} MiB, and a recording takes at most {}: reduce the "
                          "camera's region (camera.set, roi)",
                          bytes >> 20, kMaxRecordedImageBytes >> 20));
}

/// Allocates the frame buffer, which takes up to a second.
Result<std::unique_ptr<FrameStore>> store_for(std::size_t pictures, std::size_t image_bytes) {
  try {
    return std::make_unique<FrameStore>(pictures, image_bytes);
  } catch (const std::bad_alloc&) {
    return fail(Errc::unavailable, "record.buffer_mib",
                fmt::format("there is not enough memory to buffer {} images: reduce it", pictures));
  }
}

Result<void> add(RecordFile& file, const Document& document) {
  return file.add_document(document.kind, document.sha256, document.text);
}

Result<void> add_first_documents(RecordFile& file, const Recorder::Begin& begin,
                                 const Document& camera) {
  const Document config{"configuration", begin.config, sha256_hex(begin.config)};
  if (auto added = add(file, config); !added) return added;
  return add(file, camera);
}

}  // namespace

bool RecordTaker::do_work() {
  FrameRecord* const record = pipeline_.next_recorded(kTurnUs);
  if (record == nullptr) return false;
  const auto release = [this](FrameRecord* one) { pipeline_.release_recorded(one); };
  const std::unique_ptr<FrameRecord, decltype(release)> held(record, release);
  frames_.serve_record(*record);
  return true;
}

struct Recorder::Running {
  std::string path;
  RecordStart asked;
  RecordingHeader header;
  std::unique_ptr<RecordFile> file;
  std::unique_ptr<FrameStore> store;
  PlanDocuments documents;
  /// New camera settings before their first frame, with the monotonic time of the change, ns.
  std::deque<std::pair<std::int64_t, Waiting>> camera_documents;
  std::string camera_sha256;            ///< of the newest camera settings
  std::vector<Waiting> loop_documents;  ///< not yet written
  std::vector<LoopCut> loop_cuts;       ///< of runs that were cut in this recording
  std::uint64_t documents_before = 0;   ///< value of documents_dropped_ at record.start
  std::int64_t t_begin_mono_ns = monotonic_ns();
  std::int64_t next_flush_ns = 0;
  std::uint64_t last_number = 0;   ///< 0: no frame yet
  std::uint64_t frames_begun = 0;  ///< frames taken from the buffer, written or not
  std::uint64_t last_plan_id = 0;
  std::uint64_t frames_dropped = 0, pictures_dropped = 0;
  std::optional<FrameTap> tap;  ///< fills `store`, so declared after it
};

Recorder::Recorder(const Config& config, Pipeline& pipeline, FrameTaps& frames, Events& events)
    : folder_(config),
      buffer_bytes_(std::size_t(config.record.buffer_mib) << 20),
      wavelength_nm_(config.optics.wavelength_nm),
      pipeline_(pipeline),
      frames_(frames),
      events_(events),
      taker_(pipeline, frames),
      max_facts_(kIdleFacts),
      beams_(config.beams.size()) {}

Recorder::~Recorder() = default;

void Recorder::add_plan(const MeasurementPlan& plan, SensorView sensor) {
  auto facts = std::make_shared<const PlanFacts>(plan, std::move(sensor));
  const std::lock_guard lock(facts_mutex_);
  const std::size_t bytes = facts_bytes_ + bytes_of(*facts);
  const bool is_full = facts_.size() >= max_facts_ || bytes > kMaxFactsBytes;
  if (max_facts_ > kIdleFacts && is_full && facts_.size() > kIdleFacts) {
    // The frames that wait for the disk are the oldest of the recording, and need the oldest plans.
    facts_bytes_ -= bytes_of(*facts_.back());
    facts_.pop_back();
    ++documents_dropped_;
  }
  facts_bytes_ += bytes_of(*facts);
  facts_.push_back(std::move(facts));
  drop_facts();
}

/// Drops the oldest plans beyond the limit. Call with facts_mutex_ locked.
void Recorder::drop_facts() {
  for (; facts_.size() > max_facts_; facts_.pop_front()) facts_bytes_ -= bytes_of(*facts_.front());
}

void Recorder::keep_facts(std::size_t most) {
  const std::lock_guard lock(facts_mutex_);
  max_facts_ = most;
  drop_facts();
}

std::shared_ptr<const PlanFacts> Recorder::facts_of(std::uint64_t plan_id) {
  const std::lock_guard lock(facts_mutex_);
  const auto found = std::find_if(facts_.begin(), facts_.end(),
                                  [&](const auto& one) { return one->plan.id == plan_id; });
  if (found == facts_.end()) return nullptr;
  // Frames come in the order of their plans.
  for (auto one = facts_.begin(); one != found; ++one) facts_bytes_ -= bytes_of(**one);
  facts_.erase(facts_.begin(), found);
  return facts_.front();
}

void Recorder::size_of(const CameraSettings& camera, int pictures_every,
                       std::function<void(const RecordSize&)> done) {
  mailbox_.post([this, camera, pictures_every, done = std::move(done)] {
    done(size_of(camera, pictures_every));
  });
}

RecordSize Recorder::size_of(const CameraSettings& camera, int pictures_every) {
  const double image_bytes =
      double(row_bytes(camera.pixel_format, camera.roi.width)) * camera.roi.height;
  const RecordedWidth width = expected_width();
  const double frame_bytes = double(sizeof(RecordedFrame) + sizeof(std::int64_t) +
                                    width.spots * (1 + width.beams) * sizeof(RecordedSpot) +
                                    width.modes * 2 * sizeof(float));
  RecordSize size;
  size.bytes_per_frame =
      frame_bytes + (pictures_every == 0 ? 0.0 : image_bytes / double(pictures_every));
  size.bytes_per_hour = size.bytes_per_frame * camera.frame_rate_hz * 3600.0;
  size.bytes_free = folder_.free_bytes();
  if (size.bytes_free) size.hours_free = double(*size.bytes_free) / size.bytes_per_hour;
  return size;
}

RecordedWidth Recorder::expected_width() {
  const std::lock_guard lock(facts_mutex_);
  RecordedWidth width;
  width.beams = beams_;
  if (facts_.empty()) return width;
  const MeasurementPlan& plan = facts_.back()->plan;
  width.spots = plan.predicted_px.size();
  width.modes = plan.modes_j.size();
  return width;
}

void Recorder::camera_changed(const CameraSettings& settings,
                              const std::optional<CameraInfo>& info) {
  auto now = waiting(make_document("camera", camera_content(settings, info)));
  if (!now) {
    ++documents_dropped_;
    return;
  }
  mailbox_.post([this, now = std::move(*now), changed_ns = monotonic_ns()] {
    if (!running_) return;
    // Repeated settings are ignored: while the daemon searches for a camera, it announces them
    // every second.
    const std::string& sha256 = now.document.sha256;
    if (std::exchange(running_->camera_sha256, sha256) == sha256) return;
    running_->camera_documents.emplace_back(changed_ns, now);
  });
}

void Recorder::add_loop(std::string kind, nlohmann::json content) {
  if (kind == "loop") loop_cut_ = nullptr;
  // A run of the loop cannot be repeated without each of its documents, so the rest is of no use.
  if (loop_cut_) return void(++*loop_cut_);
  auto document = waiting(make_document(std::move(kind), content));
  if (!document) {
    loop_cut_ = std::make_shared<std::atomic<std::uint64_t>>(1);
    document = Waiting{make_document("loop_cut", nlohmann::json::object()), nullptr};
  }
  mailbox_.post([this, document = std::move(*document), cut = loop_cut_] {
    if (!running_) return;
    running_->loop_documents.push_back(document);
    if (cut) running_->loop_cuts.push_back(cut);
  });
}

/// Reserves memory for a document. None if too many wait for the disk.
std::optional<Recorder::Waiting> Recorder::waiting(Document document) {
  const std::size_t bytes = document.text.size();
  if (waiting_bytes_.fetch_add(bytes) + bytes > kMaxWaitingBytes) {
    waiting_bytes_ -= bytes;
    return std::nullopt;
  }
  return Waiting{std::move(document), {nullptr, [this, bytes](void*) { waiting_bytes_ -= bytes; }}};
}

RecordedLosses Recorder::losses() const {
  const Running& r = *running_;
  std::uint64_t documents = documents_dropped_ - r.documents_before;
  for (const LoopCut& cut : r.loop_cuts) documents += *cut;
  return {r.frames_dropped, r.pictures_dropped, documents};
}

void Recorder::start(Begin asked, Done done) {
  asked.documents_before = documents_dropped_;
  mailbox_.post([this, asked = std::move(asked), done = std::move(done)] {
    if (auto begun = begin(asked); !begun) return done(fail(begun.error()));
    done(report());
  });
}

void Recorder::stop(Done done) {
  mailbox_.post([this, done = std::move(done)] {
    if (!running_) {
      return done(fail(Errc::refused, "", "nothing is being recorded; record.get says why"));
    }
    end({"stopped by record.stop", Rest::write, Cause::asked_for});
    done(report());
  });
}

Result<void> Recorder::begin(const Begin& begin) {
  if (running_) {
    return fail(Errc::refused, "",
                running_->path + " is being recorded: end it with record.stop first");
  }
  const auto path = folder_.new_file(begin.asked.name);
  if (!path) return fail(path.error());
  const auto image_bytes = image_bytes_of(begin.camera);
  if (!image_bytes) return fail(image_bytes.error());
  const std::size_t pictures =
      begin.asked.pictures_every == 0 ? 0 : std::max<std::size_t>(4, buffer_bytes_ / *image_bytes);
  auto store = store_for(pictures, *image_bytes);
  if (!store) return fail(store.error());
  auto running = std::make_unique<Running>();
  running->path = *path;
  running->asked = begin.asked;
  running->header = header_of(begin);
  running->header.wavelength_nm = wavelength_nm_;
  auto file = RecordFile::create(*path, running->header, expected_width());
  if (!file) return fail(file.error());
  running->file = std::move(*file);
  const Document camera = make_document("camera", camera_content(begin.camera, begin.camera_info));
  running->camera_sha256 = camera.sha256;
  running->documents_before = begin.documents_before;
  if (auto added = add_first_documents(*running->file, begin, camera); !added) {
    running->file.reset();
    ::unlink(path->c_str());  // otherwise the next attempt could not use this name
    return added;
  }
  running->store = std::move(*store);
  running->tap.emplace(frames_, FrameTap::Needs::record, FrameTap::kEndless,
                       [to = running->store.get()](const FrameRecord& record) {
                         to->take(record, Pipeline::has_recorded_pixels(record));
                         return true;
                       });
  running_ = std::move(running);
  keep_facts(kMaxFacts);
  pipeline_.record(begin.asked.pictures_every);
  publish_report();
  events_.emit("record", Severity::info, "recording " + running_->path + " has started",
               {{"file", running_->path}, {"state", "recording"}});
  return {};
}

bool Recorder::do_work() {
  if (!running_) return mailbox_.run_one(kIdle);
  const bool asked = mailbox_.run_one(std::chrono::milliseconds(0));
  if (running_) turn();
  return asked || running_ != nullptr;
}

void Recorder::on_close() {
  mailbox_.close();
  if (running_) end({"the daemon is stopping", Rest::write, Cause::daemon_stops});
}

void Recorder::turn() {
  if (TakenFrame* const frame = running_->store->next(kTurnUs)) {
    const auto ending = write(*frame);
    running_->store->give_back(frame);
    if (ending) return end(*ending);
  }
  if (monotonic_ns() < running_->next_flush_ns) return;
  running_->next_flush_ns = monotonic_ns() + kFlushNs;
  if (const auto ending = flush()) end(*ending);
}

Result<void> Recorder::add_loop_documents(Running& to) {
  for (const Waiting& one : std::exchange(to.loop_documents, {})) {
    if (auto added = add(*to.file, one.document); !added) return added;
  }
  return {};
}

std::optional<Recorder::Ending> Recorder::flush() {
  Running& r = *running_;
  if (auto added = add_loop_documents(r); !added) return Ending{added.error().reason};
  if (auto flushed = r.file->flush(losses()); !flushed) {
    return Ending{flushed.error().reason};
  }
  publish_report();
  const RecordReport now = report();
  if (!r.file->in_place()) return Ending{kGone};
  if (disk_is_full(r.path)) return Ending{kDiskFull};
  if (r.asked.limit_s && now.duration_s >= *r.asked.limit_s) {
    return Ending{fmt::format("limit_s of {} s is reached", *r.asked.limit_s), Rest::write,
                  Cause::asked_for};
  }
  if (r.asked.limit_mib && double(now.bytes) >= *r.asked.limit_mib * (1 << 20)) {
    return Ending{fmt::format("limit_mib of {} MiB is reached", *r.asked.limit_mib), Rest::after,
                  Cause::asked_for};
  }
  return std::nullopt;
}

std::optional<Recorder::Ending> Recorder::write(const TakenFrame& frame) {
  Running& r = *running_;
  if (r.file->frames() >= kMaxRecordedFrames) {
    return Ending{
        "the recording has reached its maximum number of frames: start another one with "
        "record.start",
        Rest::after};
  }
  while (!r.camera_documents.empty() &&
         r.camera_documents.front().first < frame.row.t_arrival_mono_ns) {
    const auto added = add(*r.file, r.camera_documents.front().second.document);
    if (!added) return Ending{added.error().reason};
    r.camera_documents.pop_front();
  }
  if (frame.row.plan_id != r.last_plan_id) {
    if (auto ending = write_plan(frame.row.plan_id)) return ending;
    r.last_plan_id = frame.row.plan_id;
  }
  if (auto written = write_frame(frame); !written) return Ending{written.error().reason};
  return std::nullopt;
}

/// Writes the documents of a plan. Ends the recording if the plan is for another image region or
/// format, because all frames of the plan then have that image, even if it is not recorded.
std::optional<Recorder::Ending> Recorder::write_plan(std::uint64_t plan_id) {
  const auto facts = facts_of(plan_id);
  if (!facts) return std::nullopt;  // a reader of the file detects the missing plan
  const RecordingHeader& header = running_->header;
  const Roi& roi = facts->plan.roi;
  const Roi recorded{header.x, header.y, header.width, header.height};
  if (!(roi == recorded) || facts->plan.format != header.format) {
    return Ending{
        fmt::format("the camera's image changed: it is now {} x {} at {}, {}, {}", roi.width,
                    roi.height, roi.x, roi.y, pixel_format_name(facts->plan.format)),
        Rest::after};
  }
  if (!facts->plan.patterns.empty()) {
    return Ending{"a sequence of patterns is shown, which is not recorded", Rest::after};
  }
  running_->file->name_modes(facts->plan.modes_j);
  for (const Document& document : running_->documents.of(*facts)) {
    if (auto added = add(*running_->file, document); !added) return Ending{added.error().reason};
  }
  return std::nullopt;
}

Result<void> Recorder::write_frame(const TakenFrame& frame) {
  Running& r = *running_;
  RecordedFrame row = frame.row;
  if (r.last_number != 0) row.dropped_before = frame.number - r.last_number - 1;
  r.last_number = frame.number;
  ++r.frames_begun;
  r.frames_dropped += row.dropped_before;
  r.pictures_dropped += row.picture_dropped;
  if (!frame.pixels.empty()) {
    const auto picture = r.file->add_image(frame.pixels, !r.store->behind());
    if (!picture) return fail(picture.error());
    row.picture = *picture;
  }
  r.file->add_frame(row, frame.spots, frame.coefficients, frame.sigma_waves, frame.beam_spots);
  return {};
}

/// Writes the frames still in the buffer. Returns why it stopped early; empty if all are written.
std::string Recorder::write_rest(std::int64_t until_ns) {
  Running& r = *running_;
  while (TakenFrame* const frame = r.store->next(0)) {
    const auto ending = write(*frame);
    r.store->give_back(frame);
    if (ending) return ending->reason;
    if (monotonic_ns() > until_ns) return kTooSlow;
    if (monotonic_ns() < r.next_flush_ns) continue;
    r.next_flush_ns = monotonic_ns() + kFlushNs;
    const auto flushed = r.file->flush(losses());
    if (!flushed) return flushed.error().reason;
    publish_report();
    if (disk_is_full(r.path)) return kDiskFull;
  }
  return "";
}

void Recorder::end(const Ending& ending) {
  pipeline_.stop_recording();
  const bool asked_for = ending.cause == Cause::asked_for;
  const bool daemon_stops = ending.cause == Cause::daemon_stops;
  const std::int64_t until_ns =
      daemon_stops ? monotonic_ns() + kStopRestNs : std::numeric_limits<std::int64_t>::max();
  std::string trouble = ending.rest == Rest::write ? write_rest(until_ns) : "";
  Running& r = *running_;
  std::uint64_t lost = ending.rest == Rest::after ? 0 : r.store->taken_after(r.last_number);
  r.frames_dropped += lost;
  if (asked_for && trouble.empty() && !r.file->in_place()) trouble = kGone;
  if (auto added = add_loop_documents(r); !added && trouble.empty()) trouble = added.error().reason;
  const auto closed = r.file->close(losses());
  if (!closed) {
    lost += r.frames_begun - r.file->frames();
    r.frames_dropped += r.frames_begun - r.file->frames();
    if (asked_for && trouble.empty()) trouble = closed.error().reason;
  }
  std::string why = trouble.empty() ? ending.reason : ending.reason + "; " + trouble;
  if (daemon_stops && lost > 0) why += fmt::format("; {} frames could not be written", lost);
  if (daemon_stops) lost_at_stop_.store(lost);
  publish_report();
  RecordReport last = report();
  last.state = "ended";
  last.reason = why;
  report_.set(last);
  events_.emit("record", asked_for && trouble.empty() ? Severity::info : Severity::warning,
               fmt::format("recording {} has ended with {} frames: {}", r.path, last.frames, why),
               {{"file", r.path}, {"state", "ended"}, {"reason", why}});
  keep_facts(kIdleFacts);
  running_.reset();
}

void Recorder::publish_report() {
  const Running& r = *running_;
  RecordReport now;
  now.state = "recording";
  now.file = r.path;
  now.duration_s = 1e-9 * double(monotonic_ns() - r.t_begin_mono_ns);
  now.frames = r.file->frames();
  const RecordedLosses dropped = losses();
  now.frames_dropped = dropped.frames;
  now.pictures = r.file->pictures();
  now.pictures_dropped = dropped.pictures;
  now.documents_dropped = dropped.documents;
  now.bytes = r.file->bytes();
  report_.set(now);
}

}  // namespace ovws
