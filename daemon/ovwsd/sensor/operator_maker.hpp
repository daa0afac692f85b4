/// Background computation of diffractive operators, which takes seconds each.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "core/rt/agent.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws {

/// Agent of the `model` thread. It works on the newest request only; it cancels the one before.
class OperatorMaker : public Agent {
 public:
  using Done = std::function<void(const OperatorKey&, Result<ModeOperator>)>;

  explicit OperatorMaker(const SlmGeometry& slm) : slm_(slm) {}

  bool do_work() override;

  // Thread-safe.
  /// Requests an operator. `done` is called in the `model` thread, unless the request is cancelled.
  /// A request for the key that is being computed changes nothing.
  void request(const OperatorKey& key, Done done);
  /// Cancels the request, waiting or running.
  void cancel();
  /// Cancels the request and accepts no more. A running computation ends within two propagations of
  /// the model.
  void end_soon();

 private:
  struct Request {
    OperatorKey key;
    Done done;
  };
  SlmGeometry slm_;
  std::mutex mutex_;
  std::condition_variable requested_;
  std::optional<Request> request_;     ///< waiting
  std::optional<OperatorKey> making_;  ///< being computed
  bool ending_ = false;
  std::atomic<bool> stop_{false};  ///< cancels the running computation
};

}  // namespace ovws
