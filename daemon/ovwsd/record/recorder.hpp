/// Recordings: every frame that leaves the pipeline, with all that its numbers depend on, into one
/// file. The pipeline never waits for it.
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
#include "daemon/ovwsd/record/frame_store.hpp"
#include "daemon/ovwsd/record/plan_facts.hpp"
#include "daemon/shared/guarded.hpp"
#include "drivers/record/record_file.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// The record thread's agent: copies what the pipeline lends, and gives it back at once.
class RecordTaker : public Agent {
 public:
  explicit RecordTaker(Pipeline& pipeline) : pipeline_(pipeline) {}

  bool do_work() override;

  /// From now on frames go there; nullptr: nowhere. Returns what was before. Thread-safe.
  std::unique_ptr<FrameStore> exchange(std::unique_ptr<FrameStore> store);
  /// Writing thread, which is the only one to exchange it.
  FrameStore* store() const { return store_.get(); }

 private:
  Pipeline& pipeline_;
  std::mutex mutex_;
  std::unique_ptr<FrameStore> store_;
};

/// The write thread's agent.
class Recorder : public Agent {
 public:
  using Done = std::function<void(Result<RecordReport>)>;
  /// What was in force when it was asked for.
  struct Begin {
    RecordStart asked;
    std::string config;  ///< in use, as its file would be
    CameraSettings camera;
    std::optional<CameraInfo> camera_info;
    std::string program;  ///< name and version
  };

  Recorder(const Config& config, Pipeline& pipeline, Events& events);
  ~Recorder() override;

  bool do_work() override;
  /// Ends the recording: what waits is written, for two minutes at most; what remains is counted.
  void on_close() override;
  Agent& taker() { return taker_; }

  // Any thread; `done` is called in the write thread. Errors of `start`: Errc::refused (one is on,
  // there is no folder, or the file is there already), Errc::unavailable (the disk).
  void start(Begin begin, Done done);
  void stop(Done done);
  RecordReport report() const { return report_.get(); }
  /// How many frames of a recording that the daemon's stop ended are not in its file.
  std::uint64_t lost_at_stop() const { return lost_at_stop_.load(); }
  /// Any thread, before a frame can be measured with the plan.
  void know(const MeasurementPlan& plan, SensorView sensor);
  /// Any thread.
  void camera_changed(const CameraSettings& settings, const std::optional<CameraInfo>& info);

 private:
  struct Running;
  /// Of frames that still wait in memory when a recording ends.
  enum class Rest {
    write,  ///< they belong into it
    drop,   ///< they do, and cannot be written
    after,  ///< they came after its end
  };
  struct Ending {
    std::string reason;
    Rest rest = Rest::drop;
    bool at_stop = false;  ///< of the daemon
  };
  Result<std::string> path_of(const std::string& name) const;
  Result<void> begin(const Begin& begin);
  std::optional<Ending> write(const TakenFrame& frame);
  std::optional<Ending> write_plan(std::uint64_t plan_id);
  Result<void> write_frame(const TakenFrame& frame);
  void turn();
  std::optional<Ending> flush();
  void end(const Ending& ending);
  std::string write_rest(std::int64_t until_ns);
  void tell();
  void keep_facts(std::size_t most);
  std::shared_ptr<const PlanFacts> facts_of(std::uint64_t plan_id);

  const std::optional<std::string> directory_;
  const std::size_t buffer_bytes_;
  const double wavelength_nm_;
  Pipeline& pipeline_;
  Events& events_;
  RecordTaker taker_;
  Mailbox mailbox_;
  std::unique_ptr<Running> running_;  ///< write thread
  Guarded<RecordReport> report_;
  std::atomic<std::uint64_t> lost_at_stop_{0};
  std::mutex facts_mutex_;
  std::size_t most_facts_;  ///< guarded by facts_mutex_
  std::deque<std::shared_ptr<const PlanFacts>> facts_;
};

}  // namespace ovws
