/// Makes diffractive operators, seconds each, on a thread that nobody waits for.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "core/rt/agent.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws {

/// The operator thread's agent: the newest order counts, an older one is given up.
class OperatorMaker : public Agent {
 public:
  using Done = std::function<void(const OperatorKey&, Result<ModeOperator>)>;

  explicit OperatorMaker(const SlmGeometry& slm) : slm_(slm) {}

  bool do_work() override;

  // Thread-safe.
  /// `done` is called in the operator thread, unless the order is given up.
  void order(const OperatorKey& key, Done done);
  /// Nothing is wanted any more.
  void give_up();
  /// Gives up, for good: what runs ends within two propagations of the model.
  void end_soon();

 private:
  struct Order {
    OperatorKey key;
    Done done;
  };
  SlmGeometry slm_;
  std::mutex mutex_;
  std::condition_variable ordered_;
  std::optional<Order> order_;         ///< not yet begun
  std::optional<OperatorKey> making_;  ///< begun
  bool ending_ = false;
  std::atomic<bool> stop_{false};  ///< what is being made is not wanted
};

}  // namespace ovws
