/// Frame taps: pass measured frames, with or without pixels, to any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

class FrameTap;

/// The open taps. The threads that serve them never wait for the threads that open and close them.
class FrameTaps {
 public:
  /// Data that a tap reads from a frame. This decides which thread serves it.
  enum class Needs {
    numbers,  ///< measured numbers only: served by the publish thread, with every frame
    pixels,   ///< the image: served by the images thread, with as many frames as it can borrow
    record,   ///< all, some with the image: served by the record thread, while one is recorded
  };

  /// Serves the taps for numbers; called by the publish thread with every frame.
  void serve_numbers(const FrameRecord& record) { numbers_.serve(record); }
  /// Whether a tap for pixels is open that has not used all its frames; called by the images
  /// thread.
  bool wants_pixels() { return pixels_.is_wanted(); }
  /// Serves the taps for pixels; called by the images thread with a borrowed frame. Rethrows an
  /// exception of a tap's `take`; this tap stays open.
  void serve_pixels(const FrameRecord& record) { pixels_.serve(record); }
  /// Serves the taps for recordings; called by the record thread with every frame of a recording.
  void serve_record(const FrameRecord& record) { record_.serve(record); }

 private:
  friend class FrameTap;
  using List = std::vector<FrameTap*>;
  /// Taps that one thread serves. A change of the list waits until this thread uses the new one.
  class Line {
   public:
    void serve(const FrameRecord& record);
    bool is_wanted();
    void add(FrameTap* tap);
    void remove(FrameTap* tap);

   private:
    class Turn;
    void change(List next);

    std::mutex mutex_;  ///< never taken by the serving thread
    std::unique_ptr<const List> list_ = std::make_unique<const List>();
    std::atomic<const List*> served_{list_.get()};
    std::atomic<std::uint64_t> turns_{0};  ///< odd while the thread serves
  };

  Line& line_for(Needs needs) {
    return needs == Needs::numbers ? numbers_ : needs == Needs::pixels ? pixels_ : record_;
  }

  Line numbers_, pixels_, record_;
};

/// One consumer's tap: open until it has used its number of frames or is closed. Only the
/// consumer's thread may call the methods, except used, done and idle_s.
class FrameTap {
 public:
  using Needs = FrameTaps::Needs;
  /// Returns true if the consumer uses the frame, which is valid only during the call. The serving
  /// thread calls it. With Needs::numbers it must neither block nor allocate, because the publish
  /// thread is on the frame path.
  using Take = std::function<bool(const FrameRecord&)>;
  /// 64 bits: the daemon runs for months, and cameras send thousands of frames per second.
  static constexpr std::int64_t kEndless = std::numeric_limits<std::int64_t>::max();

  /// Opens a tap for `frames` frames (at least 1). `taps` must outlive it.
  FrameTap(FrameTaps& taps, Needs needs, std::int64_t frames, Take take);
  ~FrameTap() { close(); }
  FrameTap(const FrameTap&) = delete;
  FrameTap& operator=(const FrameTap&) = delete;
  /// `take` is not called any more after this has returned. Do not call it in `take`.
  void close() { line_.remove(this); }

  std::int64_t used() const { return used_.load(); }
  bool done() const { return used() >= frames_; }
  /// Waits until all frames are used, for `timeout` at most. Returns whether all are used.
  bool wait_for(std::chrono::milliseconds timeout);
  /// Seconds since the last used frame; if no frame was used yet, since the tap was opened.
  double idle_s() const;

 private:
  friend class FrameTaps;
  void look_at(const FrameRecord& record);

  FrameTaps::Line& line_;
  const std::int64_t frames_;
  const Take take_;
  std::atomic<std::int64_t> used_{0};
  std::atomic<std::int64_t> t_last_used_ns_;
  SpscRing<bool> all_used_{1};  ///< wakes wait_for
};

}  // namespace ovws
