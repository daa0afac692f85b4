#include "daemon/ovws/cli/stream_follower.hpp"

#include <thread>
#include <utility>

namespace ovws::cli {
namespace {

constexpr std::chrono::seconds kRetryInterval{2};  ///< between requests to a missing daemon
constexpr std::chrono::seconds kSilence{4};  ///< before the next request; status comes every second
constexpr int kQueue = 1000;

}  // namespace

StreamFollower::StreamFollower(const Common& common, std::vector<std::string> topics,
                               std::chrono::milliseconds call_timeout)
    : common_(common), topics_(std::move(topics)) {
  common_.timeout_s = std::chrono::duration<double>(call_timeout).count();
}

void StreamFollower::request_endpoint() {
  if (Clock::now() < next_request_) return;
  const auto endpoint = stream_endpoint(common_, "endpoint");
  next_request_ = Clock::now() + kRetryInterval;
  if (!endpoint || *endpoint == endpoint_) return;
  auto stream = subscribe(common_, *endpoint, topics_, kQueue);
  if (!stream) return;
  stream_.emplace(std::move(*stream));
  endpoint_ = *endpoint;
}

std::optional<StreamMessage> StreamFollower::receive(std::chrono::milliseconds timeout) {
  request_endpoint();
  if (!stream_) {
    std::this_thread::sleep_for(timeout);
    return std::nullopt;
  }
  auto message = stream_->receive(timeout);
  if (message) next_request_ = Clock::now() + kSilence;
  return message;
}

}  // namespace ovws::cli
