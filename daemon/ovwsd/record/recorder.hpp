/// The recorder: writes every frame from the pipeline, and all data that its measurement depends
/// on, to one HDF5 file. The pipeline never waits for the recorder.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "daemon/ovwsd/record/frame_store.hpp"
#include "daemon/ovwsd/record/plan_facts.hpp"
#include "daemon/ovwsd/record/record_folder.hpp"
#include "daemon/shared/guarded.hpp"
#include "drivers/record/record_file.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// The record thread's agent: serves the taps of recordings with the frames that the pipeline
/// lends, and returns these at once.
class RecordTaker : public Agent {
 public:
  RecordTaker(Pipeline& pipeline, FrameTaps& frames) : pipeline_(pipeline), frames_(frames) {}
  bool do_work() override;

 private:
  Pipeline& pipeline_;
  FrameTaps& frames_;
};

/// Agent of the write thread: writes the frames to the HDF5 file.
class Recorder : public Agent {
 public:
  using Done = std::function<void(Result<RecordReport>)>;
  /// The state of the daemon when the recording was requested.
  struct Begin {
    RecordStart asked;
    std::string config;  ///< the configuration in use, as file text
    CameraSettings camera;
    std::optional<CameraInfo> camera_info;
    std::string program;                 ///< name and version
    std::uint64_t documents_before = 0;  ///< filled in by `start`
  };
  /// Limits of what waits for the disk, bytes: documents of the loop and the camera, and plans.
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{16} << 20;
  static constexpr std::size_t kMaxFactsBytes = std::size_t{64} << 20;

  Recorder(const Config& config, Pipeline& pipeline, FrameTaps& frames, Events& events);
  ~Recorder() override;

  bool do_work() override;
  /// Ends the recording. Writes the frames still in memory, for two minutes at most, and counts the
  /// frames that remain unwritten.
  void on_close() override;
  Agent& taker() { return taker_; }

  // `start`, `stop` and `size_of` may be called in any thread; `done` is called in the write
  // thread, because a disk may not answer. Errors of `start`: Errc::refused (a recording runs,
  // there is no folder, the file exists, the image is too large), Errc::unavailable (disk or
  // memory).
  void start(Begin begin, Done done);
  void stop(Done done);
  RecordReport report() const { return report_.get(); }
  /// Size of a recording with these settings of the camera, and the current sensor: without the
  /// documents, and of images that cannot be compressed.
  void size_of(const CameraSettings& camera, int pictures_every,
               std::function<void(const RecordSize&)> done);
  /// Frames of the last recording that could not be written when the daemon stopped; 0 if none.
  /// Frames dropped before that are not counted.
  std::uint64_t lost_at_stop() const { return lost_at_stop_.load(); }
  /// Announces a plan to the recorder, before any frame can be measured with it. Any thread.
  void add_plan(const MeasurementPlan& plan, SensorView sensor);
  /// Announces new camera settings or another camera to the recorder. Any thread.
  void camera_changed(const CameraSettings& settings, const std::optional<CameraInfo>& info);
  /// Adds a document of the closed loop to the recording, if there is one. Loop thread. If the disk
  /// is too slow, it is dropped with all that follow until the next document "loop". A document
  /// "loop_cut" then marks the place, and the recording counts what was dropped from there on.
  void add_loop(std::string kind, nlohmann::json content);

 private:
  struct Running;
  /// Dropped documents of a run of the loop: all from the first one on.
  using LoopCut = std::shared_ptr<std::atomic<std::uint64_t>>;
  /// What to do with frames that still wait in memory when a recording ends.
  enum class Rest {
    write,  ///< write the frames, which belong to the recording
    drop,   ///< drop and count frames that belong to it, but cannot be written
    after,  ///< ignore frames that came after the end of the recording
  };
  enum class Cause { trouble, asked_for, daemon_stops };
  struct Ending {
    std::string reason;
    Rest rest = Rest::drop;
    Cause cause = Cause::trouble;
  };
  /// A document on its way to the file.
  struct Waiting {
    Document document;
    std::shared_ptr<void> reserved_bytes;  ///< its part of kMaxWaitingBytes
  };
  std::optional<Waiting> waiting(Document document);
  RecordedLosses losses() const;
  Result<void> begin(const Begin& begin);
  std::optional<Ending> write(const TakenFrame& frame);
  std::optional<Ending> write_plan(std::uint64_t plan_id);
  Result<void> write_frame(const TakenFrame& frame);
  void turn();
  std::optional<Ending> flush();
  static Result<void> add_loop_documents(Running& to);
  void end(const Ending& ending);
  std::string write_rest(std::int64_t until_ns);
  void publish_report();
  void keep_facts(std::size_t most);
  void drop_facts();
  RecordSize size_of(const CameraSettings& camera, int pictures_every);
  RecordedWidth expected_width();
  std::shared_ptr<const PlanFacts> facts_of(std::uint64_t plan_id);

  const RecordFolder folder_;
  const std::size_t buffer_bytes_;
  const double wavelength_nm_;
  Pipeline& pipeline_;
  FrameTaps& frames_;
  Events& events_;
  RecordTaker taker_;
  std::atomic<std::size_t> waiting_bytes_{0};
  std::atomic<std::uint64_t> documents_dropped_{0};  ///< since the start, without the loop's
  LoopCut loop_cut_;  ///< of the loop's present run; null: none was dropped. Loop thread
  Mailbox mailbox_;
  std::unique_ptr<Running> running_;  ///< write thread
  Guarded<RecordReport> report_;
  std::atomic<std::uint64_t> lost_at_stop_{0};
  std::mutex facts_mutex_;
  std::size_t max_facts_, facts_bytes_ = 0;  ///< guarded by facts_mutex_
  std::deque<std::shared_ptr<const PlanFacts>> facts_;
  const std::size_t beams_;  ///< number of further light sources
};

}  // namespace ovws
