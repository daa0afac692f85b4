#include "daemon/ovws/study/parallel.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace ovws::study {

namespace {

using Clock = std::chrono::steady_clock;

/// Progress bar with the remaining time on standard error; see print_progress.
class Progress {
 public:
  Progress(std::string what, std::size_t total) : what_(std::move(what)), total_(total) {
    show();  // the first item may take long
  }
  ~Progress() { print_progress(""); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Counts one more finished item; thread-safe.
  void tick() {
    const std::lock_guard lock(mutex_);
    ++done_;
    constexpr std::chrono::milliseconds kPace(100);
    if (Clock::now() - shown_ < kPace) return;
    shown_ = Clock::now();
    show();
  }

 private:
  void show() {
    constexpr std::size_t kWidth = 40;
    const std::size_t filled = kWidth * done_ / std::max<std::size_t>(total_, 1);
    std::string line = fmt::format("{:<24} [{}{}] {}/{}", what_, std::string(filled, '#'),
                                   std::string(kWidth - filled, ' '), done_, total_);
    if (done_ > 0) {
      const double spent_s = std::chrono::duration<double>(Clock::now() - started_).count();
      line += fmt::format("  {:.0f} s left", spent_s * double(total_ - done_) / double(done_));
    }
    print_progress(line);
  }

  const std::string what_;
  const std::size_t total_;
  const Clock::time_point started_ = Clock::now();
  std::mutex mutex_;
  std::size_t done_ = 0;
  Clock::time_point shown_;
};

}  // namespace

void print_progress(std::string_view text) {
  if (::isatty(STDERR_FILENO) == 0) return;
  fmt::print(stderr, "\r{}\033[K", text);
  std::fflush(stderr);
}

int all_cores() {
  return int(std::max(1U, std::thread::hardware_concurrency()));
}

void parallel_for(const std::string& what, std::size_t count, int threads,
                  const std::function<void(std::size_t)>& work) {
  Progress progress(what, count);
  std::atomic<std::size_t> next{0};
  std::exception_ptr thrown;
  std::mutex mutex;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        thrown = std::current_exception();
        next = count;
      }
      progress.tick();
    }
  };
  std::vector<std::thread> crew;
  for (int k = 1; k < threads; ++k) crew.emplace_back(run);
  run();
  for (std::thread& one : crew) one.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace ovws::study
