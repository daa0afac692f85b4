/// Copies of measured frames, for threads that keep a frame longer than the frame path lends it.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/spsc_ring.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"

namespace ovws {

/// Copy of a frame: its measured numbers, in memory of fixed size, so that a ring buffer can hold
/// it; from `copy_of` its spots and its pixels, too. `frame.image` views the pixels.
struct FrameCopy : FrameStamp {
  std::uint64_t plan_id = 0, sensor_epoch = 0;  ///< of the measurement plan
  int charge = 1;
  bool valid = false;      ///< all coefficients are numbers
  int mode_count = 0;      ///< modes of the plan
  int measured_count = 0;  ///< leading modes that were measured: by spot positions, not always all
  std::array<int, kMaxModes> modes_j{};
  std::array<float, kMaxModes> coefficients{};  ///< waves, minus the reference
  std::array<float, kMaxModes> sigma_waves{};   ///< their standard errors; NaN: unknown
  /// The correction in the plan's hologram, with piston: see is_of_own_hologram.
  int correction_count = 0;
  std::array<Mode, kMaxModes + 1> correction{};
  std::vector<SpotFix> spots;
  std::shared_ptr<const std::vector<std::byte>> pixels;  ///< null: not copied

  std::span<const float> all_coefficients() const {
    return {coefficients.data(), std::size_t(mode_count)};
  }
  template <class T>
  std::span<const T> measured(const std::array<T, kMaxModes>& of) const {
    return {of.data(), std::size_t(measured_count)};
  }
  std::span<const Mode> shown() const { return {correction.data(), std::size_t(correction_count)}; }
  // Exposure, CLOCK_MONOTONIC.
  std::int64_t t_begin_ns() const;
  std::int64_t t_middle_ns() const { return t_begin_ns() + (t_exposed_mono_ns - t_begin_ns()) / 2; }
};

/// Copies the numbers of a frame. RT-safe if `to` has neither spots nor pixels.
void copy_numbers(const FrameRecord& record, FrameCopy& to) OVWS_NONBLOCKING;
/// Copies a frame with its spots and its pixels. Throws std::bad_alloc.
FrameCopy copy_of(const FrameRecord& record);
/// Whether the plan that measured a frame is that of its hologram, so that the plan's correction is
/// the one that the frame shows. RT-safe.
inline bool is_of_own_hologram(const FrameRecord& record) {
  return record.plan->hologram_id == record.hologram_id;
}

/// Decides in the serving thread (see FrameTap::Take) whether a frame is used.
using UsableFrame = std::function<bool(const FrameRecord&)>;

/// The numbers of all usable frames, in a ring buffer. Frames that find it full are dropped and not
/// counted as used. Only one thread may call its methods.
class FrameFeed {
 public:
  FrameFeed(FrameTaps& taps, std::size_t frames, UsableFrame usable);
  /// The next frame; false if none comes within `timeout`.
  bool next(FrameCopy& to, std::chrono::microseconds timeout) { return ring_.pop(to, timeout); }
  const FrameTap& tap() const { return tap_; }

 private:
  SpscRing<FrameCopy> ring_;
  FrameCopy incoming_;  ///< publish thread only
  FrameTap tap_;        ///< fills the members above, so declared after them
};

/// One usable frame at a time with its pixels, on demand, for a thread that works on a frame for up
/// to seconds. Only this thread may call its methods.
class FrameInbox {
 public:
  /// `taps` must outlive this object.
  FrameInbox(FrameTaps& taps, UsableFrame usable) : taps_(taps), usable_(std::move(usable)) {}

  /// Requests a usable frame and waits for it, for `timeout` at most; none if none came. The
  /// request then stays open for the next call.
  std::optional<FrameCopy> next(std::chrono::milliseconds timeout);
  /// Withdraws the request, and drops a frame that has already arrived.
  void forget() { tap_.reset(); }

 private:
  FrameTaps& taps_;
  const UsableFrame usable_;
  FrameCopy frame_;
  std::optional<FrameTap> tap_;  ///< fills frame_, so declared after it
};

}  // namespace ovws
