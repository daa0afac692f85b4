/// Frame broker: serves "the next n frames for which ..., with or without pixels" to any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "core/pipeline/frame_record.hpp"

namespace ovws {

class FrameBroker {
 public:
  /// What a request reads of a frame, which decides the thread that serves it.
  enum class Needs {
    numbers,  ///< no pixels: served by the publish thread, with every frame
    pixels,   ///< the image: served by the images thread, with as many frames as it can borrow
  };
  /// Looks at a frame, which is lent until it returns; true if the frame is used. Called in the
  /// serving thread while the request is locked. It does not allocate if it needs numbers only: the
  /// publish thread is on the frame path.
  using Take = std::function<bool(const FrameRecord&)>;

 private:
  struct Line;

 public:
  /// A request that is open until it has used its number of frames or is destroyed. Its methods may
  /// be called from any thread.
  class Request {
   public:
    /// `take` is not called again after this has returned.
    ~Request();
    Request(const Request&) = delete;
    Request& operator=(const Request&) = delete;

    int used() const { return used_.load(); }
    bool done() const { return used() >= frames_; }
    /// Waits until all frames are used, `timeout` at most; whether they are.
    bool wait_for(std::chrono::milliseconds timeout) const;
    /// Since the last used frame, or since the request was made.
    double idle_s() const;

   private:
    friend class FrameBroker;
    Request(Line& line, int frames, Take take);
    void look_at(const FrameRecord& record);

    Line& line_;
    const int frames_;
    const Take take_;
    std::atomic<int> used_{0};
    std::atomic<std::int64_t> t_last_used_ns_;
  };

  /// Any thread. Opens a request for `frames` frames, 1 or more, that `take` uses. The broker
  /// outlives it.
  [[nodiscard]] std::unique_ptr<Request> request(Needs needs, int frames, Take take);

  /// Publish thread, with every frame. Reads one flag while nothing is requested.
  void serve_numbers(const FrameRecord& record) { serve(numbers_, record); }
  /// Images thread: whether a request for pixels is open.
  bool wants_pixels() const { return pixels_.open_count.load() > 0; }
  /// Images thread, with a borrowed frame. Throws what a request's `take` throws; the request stays
  /// open.
  void serve_pixels(const FrameRecord& record) { serve(pixels_, record); }

 private:
  /// The open requests that one thread serves.
  struct Line {
    std::mutex mutex;
    std::condition_variable served;
    std::vector<Request*> open;
    std::atomic<int> open_count{0};  ///< of `open`, for a look without the lock

    void remove(const Request* request);  ///< call with the lock held
  };
  static void serve(Line& line, const FrameRecord& record);

  Line numbers_, pixels_;
};

}  // namespace ovws
