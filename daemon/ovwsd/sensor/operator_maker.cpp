#include "daemon/ovwsd/sensor/operator_maker.hpp"

#include <chrono>
#include <utility>

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(50);

}  // namespace

bool OperatorMaker::do_work() {
  std::optional<Request> request;
  {
    std::unique_lock lock(mutex_);
    if (!requested_.wait_for(lock, kTurn, [this] { return request_.has_value(); })) return false;
    request.swap(request_);
    making_ = request->key;
    stop_ = false;
  }
  auto made = diffractive_operator(request->key, slm_, &stop_);
  {
    const std::lock_guard lock(mutex_);
    making_.reset();
    if (stop_) return true;
  }
  request->done(request->key, std::move(made));
  return true;
}

void OperatorMaker::request(const OperatorKey& key, Done done) {
  {
    const std::lock_guard lock(mutex_);
    request_.reset();
    if (ending_ || (making_ == key && !stop_)) return;
    stop_ = true;
    request_ = Request{key, std::move(done)};
  }
  requested_.notify_one();
}

void OperatorMaker::cancel() {
  const std::lock_guard lock(mutex_);
  request_.reset();
  stop_ = true;
}

void OperatorMaker::end_soon() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  request_.reset();
  stop_ = true;
}

}  // namespace ovws
