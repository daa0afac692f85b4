/// Parallel loop with a progress bar, and the line that shows progress.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace ovws::study {

/// Replaces the progress line on standard error; an empty `text` removes it. Prints nothing if
/// standard error is not a terminal.
void print_progress(std::string_view text);

/// Progress bar with the remaining time on standard error; see print_progress.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void tick();  ///< counts one more finished item; thread-safe

 private:
  void show();

  std::string what_;
  std::size_t total_;
  std::chrono::steady_clock::time_point started_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point shown_;
};

/// The number of hardware threads; at least 1.
int all_cores();

/// Calls `work(i)` once for each i below `count` on `threads` threads, the caller's included.
/// Rethrows an exception of `work` after all threads have ended.
void parallel_for(const std::string& what, std::size_t count, int threads,
                  const std::function<void(std::size_t)>& work);

}  // namespace ovws::study
