/// Conducts the steps of a commissioning: one action at a time, in a thread of its own.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/examine/commission/step.hpp"

namespace ovws::commission {

/// Thread-safe; see Commissioning for what its functions promise.
class Conductor {
 public:
  explicit Conductor(Commissioning::Settings settings);
  ~Conductor();
  Conductor(const Conductor&) = delete;
  Conductor& operator=(const Conductor&) = delete;

  Report report() const;
  Image<std::uint8_t> picture(const Step& step) const;
  void cancel();

  // Begin an action. Errc::refused while another one runs.
  Result<void> look();
  Result<void> run(const Step& step);
  Result<void> skip(const Step& step);
  Result<void> undo(const Step& step);
  Result<void> take(const Step& step, const Way& way);

  /// What the step's last run offers.
  std::vector<Way> ways(const Step& step) const;

 private:
  /// What a step's last action left behind.
  struct Record {
    bool skipped = false, failed = false, passed = false;
    std::optional<Verdict> verdict;
    std::vector<Way> ways;
    std::vector<std::string> commands;
    Image<std::uint8_t> picture;
    int pictures = 0;
    Memory memory;
  };

  void work();
  Result<void> begin(const Step* step, std::string text, std::function<void()> action);
  Bench bench();

  // In the worker thread.
  void look_now();
  void run_now(const Step& step);
  void take_now(const Step& step, const Way& way);
  void undo_now(const Step& step);
  void keep(const Step& step, Outcome outcome);

  // With the mutex locked.
  Record& record(const Step& step) { return records_[std::size_t(&step - steps().data())]; }
  const Record& record(const Step& step) const {
    return records_[std::size_t(&step - steps().data())];
  }
  State state_of(const Step& step) const;
  bool can_undo(const Step& step) const;
  StepReport report_of(const Step& step) const;

  const Commissioning::Settings settings_;
  std::atomic<bool> cancelled_{false};
  mutable std::mutex mutex_;  ///< guards all below but the thread
  std::condition_variable wake_;
  bool ending_ = false;
  std::function<void()> next_;
  std::optional<Running> running_;  ///< from the request of an action until its end
  std::vector<Record> records_;
  Look seen_;
  std::thread worker_;
};

}  // namespace ovws::commission
