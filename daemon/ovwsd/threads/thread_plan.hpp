/// The thread table: which threads the daemon has, how they are scheduled, and what they may wait
/// for. No other code creates threads.
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
  status,
  replay,
  display,
};

/// The reaction to a turn that takes too long.
enum class OnHang {
  restart,  ///< our own fault: the systemd watchdog is no longer fed
  report,   ///< a device or long work blocks the thread, and would block that of a new process
};

/// The reaction to an exception that leaves a turn.
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

constexpr std::array<ThreadRow, 18> kThreadTable{{
    {ThreadRole::acquire, "acquire", 80, "the camera's next frame", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::track, "track", 75, "its ring buffer", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::reconstruct, "reconstruct", 74, "its ring buffer", 2.0, OnHang::restart, 0,
     OnException::restart},
    {ThreadRole::publish, "publish", 60,
     "its ring buffer, the rebinding of its socket (a key was withdrawn)", 5.0, OnHang::restart},
    {ThreadRole::camera, "camera", 0, "camera registers, discovery", 30.0, OnHang::restart},
    {ThreadRole::prepare, "prepare", 0, "its mailbox, the display presenting a hologram", 30.0,
     OnHang::restart, 0, OnException::restart},
    {ThreadRole::procedure, "procedure", 0, "frames, the other threads; a procedure takes minutes",
     86400.0, OnHang::report},
    {ThreadRole::loop, "loop", 0, "the next usable frame, the display presenting a hologram", 30.0,
     OnHang::restart},
    {ThreadRole::control, "control", 0, "requests", 5.0, OnHang::restart},
    {ThreadRole::images, "images", 0, "the next frame with its pixels, the rebinding of its socket",
     5.0, OnHang::restart},
    {ThreadRole::record, "record", 50, "the next recorded frame, the start and end of a recording",
     5.0, OnHang::restart},
    {ThreadRole::write, "write", 0, "the disk", 60.0, OnHang::report, 5},
    {ThreadRole::disk, "disk", 0, "the disk", 5.0, OnHang::report},
    {ThreadRole::search, "search", 0,
     "the next frame with its pixels; renderings take up to a second", 30.0, OnHang::report, 5},
    {ThreadRole::refine, "refine", 0,
     "the next frame with its pixels; renderings take up to a second", 120.0, OnHang::report, 15},
    {ThreadRole::status, "status", 0, "the clock", 5.0, OnHang::restart},
    {ThreadRole::replay, "replay", 0, "the next frame of ovws replay", 5.0, OnHang::report},
    {ThreadRole::display, "main", 0, "the display", 5.0, OnHang::report, 0,
     OnException::restart},  // made by the system
}};

/// Reduces the default stack size to 1 MiB, for threads of libraries, too: whole stacks count
/// against the limit of locked memory (RLIMIT_MEMLOCK). Call once, before any thread is created.
void keep_stacks_small();

/// Checks that this process may run on these processors; if not, Errc::invalid, field
/// pipeline.cpus.
Result<void> check_cpus(const std::vector<int>& cpus);

struct HungThread {
  const ThreadRow* row = nullptr;
  double turn_s = 0.0;  ///< so far
};

/// Report of an exception that left a turn of this thread.
struct ThreadFailure {
  const ThreadRow* row = nullptr;
  std::string what;
};
/// Called in the thread that failed.
using OnThreadFailure = std::function<void(const ThreadFailure&)>;

/// Starts agents on threads, detects hung threads, and stops them. Main thread only, unless stated
/// otherwise.
class ThreadPlan {
 public:
  /// Threads of the frame path (those with a SCHED_FIFO priority) are pinned to `frame_path_cpus`,
  /// which check_cpus has accepted; empty: they run on any processor. Exceptions that leave a turn
  /// are passed to `on_failure`, or logged if there is none.
  explicit ThreadPlan(RealtimePolicy policy, std::vector<int> frame_path_cpus = {},
                      OnThreadFailure on_failure = {});
  ~ThreadPlan();
  ThreadPlan(const ThreadPlan&) = delete;
  ThreadPlan& operator=(const ThreadPlan&) = delete;

  /// Locks the process's memory (mlockall): the program and its libraries as a whole, memory that
  /// is mapped later as it is first used. Keeps the processor out of deep idle states
  /// (/dev/cpu_dma_latency). What the system refuses is a warning, with `enforce` an error.
  Result<void> prepare_process();
  /// Runs `agent` in a new thread until stop_all. Processors that it cannot be pinned to are an
  /// error; with `enforce`, a refused priority is one, too.
  Result<void> start(ThreadRole role, Agent& agent);
  /// Runs `agent` in the calling thread until `stop` is set, or until an exception leaves a turn of
  /// a thread whose row then ends the process.
  void run_here(ThreadRole role, Agent& agent, const std::atomic<bool>& stop);
  /// Asks these threads to end after their turn, and does not wait. Any thread.
  void end_soon(const std::vector<ThreadRole>& roles);
  /// Joins these threads, last started first, within `patience_s` in all. A thread may be blocked
  /// by a device that no longer answers, or by work that cannot be interrupted: then its name is
  /// returned, and the process must end without destroying what that thread uses. Empty: all ended.
  /// One caller at a time.
  std::string wait_for_end(const std::vector<ThreadRole>& roles, double patience_s);
  /// end_soon and wait_for_end for all threads that have not ended yet.
  std::string stop_all(double patience_s);

  /// Thread-safe: why the process must end and be restarted; empty: there is no reason.
  std::string fatal_failure() const;

  /// Thread-safe: the threads whose turn takes longer than their row allows.
  std::vector<HungThread> hung_threads() const;
  /// Status thread: whether `stop` of run_here has been seen set for `patience_s` while the turn
  /// still lasts.
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
  int dma_latency_fd_ = -1;  ///< the request holds while it is open; -1: none
  /// Guards threads_, which the status thread reads, and fatal_failure_.
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Running>> threads_;
  std::unique_ptr<Running> here_;
  const std::atomic<bool>* stop_here_ = nullptr;
  std::int64_t stop_seen_ns_ = 0;  ///< 0: not yet
};

}  // namespace ovws
