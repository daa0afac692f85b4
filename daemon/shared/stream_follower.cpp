#include "daemon/shared/stream_follower.hpp"

#include <thread>
#include <utility>

namespace ovws::cli {
namespace {

constexpr std::chrono::seconds kRetryInterval{1};  ///< between requests to a missing daemon
constexpr std::chrono::seconds kSilence{3};        ///< time without a message before a new request

}  // namespace

StreamFollower::StreamFollower(Common common, const char* key, std::vector<std::string> topics,
                               int queue)
    : common_(std::move(common)), key_(key), topics_(std::move(topics)), queue_(queue) {}

void StreamFollower::subscribe_again() {
  if (Clock::now() < next_request_) return;
  auto stream = open_stream(common_, key_, topics_, queue_);
  next_request_ = Clock::now() + (stream ? kSilence : kRetryInterval);
  if (stream) stream_.emplace(std::move(*stream));
}

std::optional<StreamMessage> StreamFollower::receive(std::chrono::milliseconds timeout) {
  subscribe_again();
  if (!stream_) {
    std::this_thread::sleep_for(timeout);
    return std::nullopt;
  }
  auto message = stream_->receive(timeout);
  if (message) next_request_ = Clock::now() + kSilence;
  return message;
}

}  // namespace ovws::cli
