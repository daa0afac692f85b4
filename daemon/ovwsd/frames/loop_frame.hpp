/// What the closed loop and loop.identify need of a frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Modes of one frame and the correction in its hologram. A value of fixed size, for ring buffers.
struct LoopFrame {
  std::uint64_t frame_id = 0, hologram_id = 0;
  /// Exposure, CLOCK_MONOTONIC, see FrameRecord::t_exposed_mono_ns.
  std::int64_t t_begin_ns = 0, t_end_ns = 0;
  std::int64_t transfer_ns = 0;  ///< longest time from end of exposure to arrival
  std::int64_t period_ns = 0;    ///< of the camera's frames; 0: unknown
  int mode_count = 0;
  std::array<int, kMaxModes> modes_j{};
  std::array<float, kMaxModes> waves{};        ///< coefficients
  std::array<float, kMaxModes> sigma_waves{};  ///< their standard errors; NaN: unknown
  int correction_count = 0;
  std::array<Mode, kMaxModes + 1> correction{};  ///< with piston

  std::int64_t middle_ns() const { return t_begin_ns + (t_end_ns - t_begin_ns) / 2; }
  template <class T>
  std::span<const T> measured(const std::array<T, kMaxModes>& of) const {
    return {of.data(), std::size_t(mode_count)};
  }
  std::span<const Mode> shown() const { return {correction.data(), std::size_t(correction_count)}; }
};

/// Copies a settled frame's measured modes. False, and nothing is copied, if the plan that measured
/// the frame is not that of its hologram. RT-safe.
bool copy_to(LoopFrame& frame, const FrameRecord& record) OVWS_NONBLOCKING;

}  // namespace ovws
