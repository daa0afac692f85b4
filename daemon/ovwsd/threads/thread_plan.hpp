/// The one table of threads: who runs, how it is scheduled, what it may wait for. Nothing else
/// creates a thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/rt/agent.hpp"

namespace ovws {

enum class ThreadRole {
  acquire,
  track,
  reconstruct,
  publish,
  camera,
  prepare,
  procedure,
  loop,
  control,
  images,
  record,
  write,
  disk,
  search,
  refine,
  model,
  status,
  replay,
  display,
};

/// What a turn that takes too long calls for.
enum class OnHang {
  restart,  ///< our own fault: the watchdog is no longer fed
  report,   ///< a device or long work holds the thread, and would hold that of a new process
};

/// What an exception that leaves a turn calls for.
enum class OnException {
  go_on,    ///< the turn is lost, the next one begins after a second
  restart,  ///< frames or holograms may be left half done: the process ends, systemd restarts it
};

struct ThreadRow {
  ThreadRole role;
  const char* name;          ///< as in /proc and top
  int fifo_priority;         ///< SCHED_FIFO priority; 0: the system's normal scheduling
  const char* may_wait_for;  ///< and nothing else
  double longest_turn_s;     ///< a turn that takes longer counts as hung
  OnHang on_hang;
  int nice = 0;  ///< above 0: gives way to all other threads of normal scheduling
  OnException on_exception = OnException::go_on;
};

constexpr std::array<ThreadRow, 19> kThreadTable{{
    {ThreadRole::acquire, "acquire", 80, "the camera's next frame", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::track, "track", 75, "its ring", 2.0, OnHang::restart, 0, OnException::restart},
    {ThreadRole::reconstruct, "reconstruct", 74, "its ring", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::publish, "publish", 60,
     "its ring, its socket being bound anew (a key was withdrawn)", 5.0, OnHang::restart},
    {ThreadRole::camera, "camera", 0, "camera registers, discovery", 30.0, OnHang::restart},
    {ThreadRole::prepare, "prepare", 0, "its mailbox, the display taking a hologram", 30.0,
     OnHang::restart},
    {ThreadRole::procedure, "procedure", 0, "frames, the other threads; a procedure takes minutes",
     86400.0, OnHang::report},
    {ThreadRole::loop, "loop", 0, "the next usable frame, a hologram being shown", 30.0,
     OnHang::restart},
    {ThreadRole::control, "control", 0, "requests", 5.0, OnHang::restart},
    {ThreadRole::images, "images", 0, "the next lent frame, its socket being bound anew", 5.0,
     OnHang::restart},
    {ThreadRole::record, "record", 50, "the next recorded frame, a recording's begin and end", 5.0,
     OnHang::restart},
    {ThreadRole::write, "write", 0, "the disk", 60.0, OnHang::report, 5},
    {ThreadRole::disk, "disk", 0, "the disk", 5.0, OnHang::report},
    {ThreadRole::search, "search", 0, "the next lent frame; a search takes a second", 30.0,
     OnHang::report},
    {ThreadRole::refine, "refine", 0, "the next lent frame; a fit takes seconds", 120.0,
     OnHang::report, 15},
    {ThreadRole::model, "model", 0, "an order; a diffractive matrix takes seconds", 300.0,
     OnHang::report, 15},
    {ThreadRole::status, "status", 0, "the clock", 5.0, OnHang::restart},
    {ThreadRole::replay, "replay", 0, "the next picture of ovws replay", 5.0, OnHang::report},
    {ThreadRole::display, "main", 0, "the display", 5.0, OnHang::report, 0,
     OnException::restart},  // made by the system
}};

/// Once, before any thread is made, those of libraries included: locked memory holds stacks whole,
/// and at the system's 8 MiB each those of twenty threads are 160 MB.
void keep_stacks_small();

/// Errc::invalid, field pipeline.cpus: this process may not run on one of these processors.
Result<void> check_cpus(const std::vector<int>& cpus);

struct HungThread {
  const ThreadRow* row = nullptr;
  double turn_s = 0.0;  ///< so far
};

/// An exception left a turn of this thread.
struct ThreadFailure {
  const ThreadRow* row = nullptr;
  std::string what;
};
/// Called in the thread that failed.
using OnThreadFailure = std::function<void(const ThreadFailure&)>;

/// Starts agents on threads, watches that they turn, and stops them. Main thread only, but for what
/// says otherwise.
class ThreadPlan {
 public:
  /// Threads of the frame path (those with a SCHED_FIFO priority) keep to `frame_path_cpus`, of
  /// which check_cpus has nothing to say; empty: they run anywhere. Exceptions that leave a turn
  /// are given to `on_failure`, or logged if there is none.
  explicit ThreadPlan(RealtimePolicy policy, std::vector<int> frame_path_cpus = {},
                      OnThreadFailure on_failure = {});
  ~ThreadPlan();
  ThreadPlan(const ThreadPlan&) = delete;
  ThreadPlan& operator=(const ThreadPlan&) = delete;

  /// Locks the process's memory, and keeps the processor out of sleep that takes long to wake from,
  /// if the system lets it. With `enforce`, what is missing is an error.
  Result<void> prepare_process();
  /// `agent` is turned until stop_all. Processors that cannot be had are an error; with `enforce`,
  /// a priority that cannot be had is one, too.
  Result<void> start(ThreadRole role, Agent& agent);
  /// Turns `agent` in the calling thread until `stop` is set, or until an exception left a turn of
  /// a thread whose row then ends the process.
  void run_here(ThreadRole role, Agent& agent, const std::atomic<bool>& stop);
  /// Asks these to end with their turn; waits for nothing. Any thread.
  void end_soon(const std::vector<ThreadRole>& roles);
  /// Waits for these, last started first, for `patience_s` in all. A thread may be held by a device
  /// that no longer answers, or by work that cannot be broken off: then its name is returned, and
  /// the process is to end without destroying what that thread uses. Empty: all ended. One thread
  /// at a time.
  std::string wait_for_end(const std::vector<ThreadRole>& roles, double patience_s);
  /// Both, of all that have not ended yet.
  std::string stop_all(double patience_s);

  /// Thread-safe: why the process is to end and be started again; empty: there is no reason.
  std::string fatal_failure() const;

  /// Thread-safe: those whose turn takes too long.
  std::vector<HungThread> hung_threads() const;
  /// Status thread: `stop` of run_here has been seen set for `patience_s`, and the turn still
  /// lasts.
  bool stop_overdue(double patience_s);

 private:
  struct Running;
  void run(Running& running);
  bool guarded(const ThreadRow& row, const std::function<void()>& work);
  static void pause(const Running& running);
  void report(const ThreadRow& row, const std::string& what);
  Result<void> pin(Running& running) const;
  Result<void> lock_memory() const;
  Result<void> keep_processor_awake();

  RealtimePolicy policy_;
  std::vector<int> frame_path_cpus_;
  OnThreadFailure on_failure_;
  std::atomic<bool> has_fatal_failure_{false};
  std::string fatal_failure_;
  int dma_latency_fd_ = -1;   ///< what was asked for holds while it is open; -1: not asked
  mutable std::mutex mutex_;  ///< of the list, which the status thread reads, and of fatal_failure_
  std::vector<std::unique_ptr<Running>> threads_;
  std::unique_ptr<Running> here_;
  const std::atomic<bool>* stop_here_ = nullptr;
  std::int64_t stop_seen_ns_ = 0;  ///< 0: not yet
};

}  // namespace ovws
