/// Frame broker: passes the next n frames that a request accepts, with or without pixels, to any
/// thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/priority_mutex.hpp"

namespace ovws {

class FrameBroker {
 public:
  /// Data that a request reads from a frame. This decides which thread serves the request.
  enum class Needs {
    numbers,  ///< measured numbers only: served by the publish thread, with every frame
    pixels,   ///< the image: served by the images thread, with as many frames as it can borrow
  };
  /// Frame callback of a request: returns true if it uses the frame. The frame is valid only during
  /// the call. The serving thread calls it with the request locked. With Needs::numbers it must not
  /// allocate, because the publish thread is on the frame path.
  using Take = std::function<bool(const FrameRecord&)>;

 private:
  struct Line;

 public:
  /// Frame request: open until it has used its number of frames or is destroyed. All methods are
  /// thread-safe.
  class Request {
   public:
    /// Closes the request. `take` is not called after the destructor has returned.
    ~Request();
    Request(const Request&) = delete;
    Request& operator=(const Request&) = delete;

    int used() const { return used_.load(); }
    bool done() const { return used() >= frames_; }
    /// Waits until all requested frames are used, for `timeout` at most. Returns whether all are
    /// used.
    bool wait_for(std::chrono::milliseconds timeout) const;
    /// Seconds since the last used frame; if no frame was used yet, since the request was made.
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

  /// Opens a request for `frames` frames (at least 1), which `take` uses. Thread-safe. The broker
  /// must outlive the request.
  [[nodiscard]] std::unique_ptr<Request> request(Needs needs, int frames, Take take);

  /// Serves requests for numbers. The publish thread calls it with every frame; it only reads one
  /// flag while no request is open.
  void serve_numbers(const FrameRecord& record) { serve(numbers_, record); }
  /// Whether a request for pixels is open; called by the images thread.
  bool wants_pixels() const { return pixels_.open_count.load() > 0; }
  /// Serves requests for pixels; called by the images thread with a borrowed frame. Rethrows an
  /// exception of a request's `take`; this request stays open.
  void serve_pixels(const FrameRecord& record) { serve(pixels_, record); }

 private:
  /// Open requests that one thread serves.
  struct Line {
    PriorityMutex mutex;  ///< the publish thread takes that of `numbers_`, too
    std::condition_variable served;
    std::vector<Request*> open;
    std::atomic<int> open_count{0};  ///< size of `open`, to be read without the lock

    void remove(const Request* request);  ///< requires that `mutex` is locked
  };
  static void serve(Line& line, const FrameRecord& record);

  Line numbers_, pixels_;
};

}  // namespace ovws
