/// Work spread over the machine's cores, with a progress bar.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace ovws::study {

/// A bar on standard error, if that is a terminal: done, and time left.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void tick();  ///< thread-safe: one more is done

 private:
  void show();

  std::string what_;
  std::size_t total_;
  bool visible_;
  std::chrono::steady_clock::time_point started_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point shown_;
};

/// How many threads the machine runs at once; at least 1.
int all_cores();

/// Calls `work(i)` once for each i below `count`, on `threads` threads; what it throws is thrown
/// here.
void parallel_for(const std::string& what, std::size_t count, int threads,
                  const std::function<void(std::size_t)>& work);

}  // namespace ovws::study
