#include "daemon/ovwsd/sensor/operator_maker.hpp"

#include <chrono>
#include <utility>

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(50);

}  // namespace

bool OperatorMaker::do_work() {
  std::optional<Order> order;
  {
    std::unique_lock lock(mutex_);
    if (!ordered_.wait_for(lock, kTurn, [this] { return order_.has_value(); })) return false;
    order.swap(order_);
    making_ = order->key;
    stop_ = false;
  }
  auto made = diffractive_operator(order->key, slm_, &stop_);
  {
    const std::lock_guard lock(mutex_);
    making_.reset();
    if (stop_) return true;
  }
  order->done(order->key, std::move(made));
  return true;
}

void OperatorMaker::order(const OperatorKey& key, Done done) {
  {
    const std::lock_guard lock(mutex_);
    order_.reset();
    if (ending_ || (making_ == key && !stop_)) return;
    stop_ = true;
    order_ = Order{key, std::move(done)};
  }
  ordered_.notify_one();
}

void OperatorMaker::give_up() {
  const std::lock_guard lock(mutex_);
  order_.reset();
  stop_ = true;
}

void OperatorMaker::end_soon() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  order_.reset();
  stop_ = true;
}

}  // namespace ovws
