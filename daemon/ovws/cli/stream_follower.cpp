#include "daemon/ovws/cli/stream_follower.hpp"

#include <thread>
#include <utility>

namespace ovws::cli {
namespace {

constexpr std::chrono::seconds kLook{2};  ///< between requests to a missing daemon
constexpr std::chrono::seconds kSilence{
    4};  ///< silence before asking again; status comes once a second
constexpr int kQueue = 1000;

}  // namespace

StreamFollower::StreamFollower(const Common& common, std::vector<std::string> topics,
                               std::chrono::milliseconds patience)
    : common_(common), topics_(std::move(topics)) {
  common_.timeout_s = std::chrono::duration<double>(patience).count();
}

void StreamFollower::look_for_daemon() {
  if (Clock::now() < next_look_) return;
  const auto endpoint = stream_endpoint(common_, "endpoint");
  next_look_ = Clock::now() + kLook;
  if (!endpoint || *endpoint == endpoint_) return;
  auto stream = subscribe(common_, *endpoint, topics_, kQueue);
  if (!stream) return;
  stream_.emplace(std::move(*stream));
  endpoint_ = *endpoint;
}

std::optional<StreamMessage> StreamFollower::receive(std::chrono::milliseconds timeout) {
  look_for_daemon();
  if (!stream_) {
    std::this_thread::sleep_for(timeout);
    return std::nullopt;
  }
  auto message = stream_->receive(timeout);
  if (message) next_look_ = Clock::now() + kSilence;
  return message;
}

}  // namespace ovws::cli
