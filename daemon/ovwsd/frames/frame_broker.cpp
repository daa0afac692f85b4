#include "daemon/ovwsd/frames/frame_broker.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {

FrameBroker::Request::Request(Line& line, int frames, Take take)
    : line_(line), frames_(frames), take_(std::move(take)), t_last_used_ns_(monotonic_ns()) {}

FrameBroker::Request::~Request() {
  const std::lock_guard lock(line_.mutex);
  line_.remove(this);
}

bool FrameBroker::Request::wait_for(std::chrono::milliseconds timeout) const {
  std::unique_lock<std::mutex> lock(line_.mutex);
  return line_.served.wait_for(lock, timeout, [this] { return done(); });
}

double FrameBroker::Request::idle_s() const {
  return 1e-9 * double(monotonic_ns() - t_last_used_ns_.load());
}

void FrameBroker::Request::look_at(const FrameRecord& record) {
  if (!take_(record)) return;
  t_last_used_ns_ = monotonic_ns();
  ++used_;
}

void FrameBroker::Line::remove(const Request* request) {
  const auto at = std::find(open.begin(), open.end(), request);
  if (at == open.end()) return;
  open.erase(at);
  open_count.store(int(open.size()));
}

std::unique_ptr<FrameBroker::Request> FrameBroker::request(Needs needs, int frames, Take take) {
  Line& line = needs == Needs::numbers ? numbers_ : pixels_;
  std::unique_ptr<Request> made(new Request(line, frames, std::move(take)));
  const std::lock_guard lock(line.mutex);
  line.open.push_back(made.get());
  line.open_count.store(int(line.open.size()));
  return made;
}

void FrameBroker::serve(Line& line, const FrameRecord& record) {
  if (line.open_count.load() == 0) return;
  std::exception_ptr failure;
  const std::lock_guard lock(line.mutex);
  for (std::size_t i = 0; i < line.open.size();) {
    Request& request = *line.open[i];
    try {
      request.look_at(record);
    } catch (...) {  // serve the other requests first, then rethrow
      failure = std::current_exception();
    }
    if (!request.done()) {
      ++i;
      continue;
    }
    line.remove(&request);
    line.served.notify_all();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ovws
