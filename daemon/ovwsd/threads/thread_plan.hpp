/// Thread table: the daemon's threads, their scheduling, and what each thread may wait for. No
/// other code creates threads.
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
  discover,
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
  status,
  replay,
  display,
};

/// Reaction to a hung turn, which takes longer than the row's longest_turn_s.
enum class OnHang {
  restart,  ///< a bug in ovwsd: stop feeding the systemd watchdog, which restarts ovwsd
  report,   ///< a device or long work blocks the thread; a restart would not help
};

/// The reaction to an exception that leaves a turn.
enum class OnException {
  go_on,    ///< drop the turn, begin the next one after a second
  restart,  ///< frames or holograms may be left half done: the process ends, systemd restarts it
};

struct ThreadRow {
  ThreadRole role;
  const char* name;          ///< thread name in /proc and top
  int fifo_priority;         ///< SCHED_FIFO priority; 0: the system's normal scheduling
  const char* may_wait_for;  ///< all that a turn may block on
  double longest_turn_s;     ///< a turn that takes longer counts as hung
  OnHang on_hang;
  int nice = 0;  ///< above 0: gives way to other threads of normal scheduling
  OnException on_exception = OnException::go_on;
};

constexpr std::array<ThreadRow, 19> kThreadTable{{
    {ThreadRole::acquire, "acquire", 80, "the camera's next frame", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::track, "track", 75, "its ring buffer", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::reconstruct, "reconstruct", 74, "its ring buffer", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::publish, "publish", 60,
     "its ring buffer, the rebinding of its socket (a key was withdrawn)", 5.0, OnHang::restart},
    {ThreadRole::camera, "camera", 0, "camera registers, discovery", 30.0, OnHang::restart},
    {ThreadRole::discover, "discover", 0, "the discovery of cameras", 30.0, OnHang::report},
    {ThreadRole::prepare, "prepare", 0, "its mailbox, the display presenting a hologram", 30.0,
     OnHang::restart, 0, OnException::restart},
    {ThreadRole::procedure, "procedure", 0, "frames, the other threads; a procedure takes minutes",
     86400.0, OnHang::report},
    {ThreadRole::loop, "loop", 0, "the next usable frame, the display presenting a hologram", 30.0,
     OnHang::restart},
    {ThreadRole::control, "control", 0, "requests", 5.0, OnHang::restart},
    {ThreadRole::images, "images", 0, "the next frame with its pixels, the rebinding of its socket",
     5.0, OnHang::restart},
    {ThreadRole::record, "record", 50, "the next recorded frame", 5.0, OnHang::restart},
    {ThreadRole::write, "write", 0, "the disk", 60.0, OnHang::report, 5},
    {ThreadRole::disk, "disk", 0, "the disk", 5.0, OnHang::report},
    {ThreadRole::search, "search", 0,
     "the next frame with its pixels; renderings take up to a second", 30.0, OnHang::report},
    {ThreadRole::refine, "refine", 0,
     "the next frame with its pixels; renderings take up to a second", 120.0, OnHang::report, 15},
    {ThreadRole::status, "status", 0, "the clock", 5.0, OnHang::restart},
    {ThreadRole::replay, "replay", 0, "the next frame of ovws replay", 5.0, OnHang::report},
    {ThreadRole::display, "main", 0, "the display", 5.0, OnHang::report, 0,
     OnException::restart},  // the main thread, which the system creates
}};

/// Reduces the default stack size to 1 MiB, also for threads of libraries. With locked memory, a
/// whole stack counts against the limit RLIMIT_MEMLOCK. Call once, before any thread is created.
void keep_stacks_small();

/// Checks that this process may run on the processors `cpus`. Error: Errc::invalid, field
/// pipeline.cpus.
Result<void> check_cpus(const std::vector<int>& cpus);

struct HungThread {
  const ThreadRow* row = nullptr;
  double turn_s = 0.0;  ///< duration of the present turn so far
};

/// Thread failure: an exception that left a turn of the thread.
struct ThreadFailure {
  const ThreadRow* row = nullptr;
  std::string what;
};
/// Callback for a thread failure; called in the thread that failed.
using OnThreadFailure = std::function<void(const ThreadFailure&)>;

/// Starts agents on threads, detects hung threads, and stops threads. Call the methods in the main
/// thread only, unless stated otherwise.
class ThreadPlan {
 public:
  /// Pins the threads of the frame path (those with a SCHED_FIFO priority) to `frame_path_cpus`,
  /// which check_cpus has accepted; empty: any processor. `on_failure` receives each exception that
  /// leaves a turn; without `on_failure`, the exception is logged.
  explicit ThreadPlan(RealtimePolicy policy, std::vector<int> frame_path_cpus = {},
                      OnThreadFailure on_failure = {});
  ~ThreadPlan();
  ThreadPlan(const ThreadPlan&) = delete;
  ThreadPlan& operator=(const ThreadPlan&) = delete;

  /// Locks the process's memory (mlockall): program and libraries at once, later mappings when
  /// first used. Keeps the processor out of deep idle states (/dev/cpu_dma_latency). A request that
  /// the system refuses is a warning; with `enforce`, an error.
  Result<void> prepare_process();
  /// Runs `agent` in a new thread until stop_all. Fails if the thread cannot be pinned to its
  /// processors; with `enforce`, also if the system refuses the real-time priority.
  Result<void> start(ThreadRole role, Agent& agent);
  /// Runs `agent` in the calling thread until `stop` is set. Also returns after an exception has
  /// left a turn of a thread whose row says OnException::restart.
  void run_here(ThreadRole role, Agent& agent, const std::atomic<bool>& stop);
  /// Requests that these threads end after their present turn. Does not wait. Thread-safe.
  void end_soon(const std::vector<ThreadRole>& roles);
  /// Joins these threads, last started first, within `patience_s` seconds in total. Returns the
  /// name of a thread that did not end; empty: all ended. A device or long work can block a thread.
  /// The process must then end without destroying what this thread uses. One caller at a time.
  std::string wait_for_end(const std::vector<ThreadRole>& roles, double patience_s);
  /// Stops all threads that have not ended yet: end_soon, then wait_for_end.
  std::string stop_all(double patience_s);

  /// Why the process must end and be restarted; empty: no reason. Thread-safe.
  std::string fatal_failure() const;

  /// Hung threads: their present turn takes longer than their row allows. Thread-safe.
  std::vector<HungThread> hung_threads() const;
  /// Whether the present turn of run_here has gone on for `patience_s` seconds since this method
  /// first saw `stop` set. Called by the status thread.
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
  int dma_latency_fd_ = -1;  ///< idle-state limit, active while this file is open; -1: none
  /// Guards threads_, which the status thread reads, and fatal_failure_.
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Running>> threads_;
  std::unique_ptr<Running> here_;
  const std::atomic<bool>* stop_here_ = nullptr;
  std::int64_t stop_seen_ns_ = 0;  ///< CLOCK_MONOTONIC when `stop` was first seen set; 0: not yet
};

}  // namespace ovws
