/// Dependencies and frame counters shared by FakeCamera and GigeDevice.
#pragma once

#include <atomic>
#include <cstdint>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/screen.hpp"

namespace ovws::twin {

struct CameraDeps {
  Screen& screen;
  Bench& bench;
  FrameSource& frames;
  Faults& faults;
};

struct FrameTally {
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped{0}, incomplete{0};    ///< by an injected fault
  std::atomic<std::uint64_t> duplicated{0}, reordered{0};  ///< by an injected fault
  std::atomic<std::uint64_t> late{0};     ///< not sent: far field or noise not ready in time
  std::atomic<std::uint64_t> refused{0};  ///< not sent: ROI outside the sensor, format unknown
  std::atomic<std::uint64_t> nudges{0};   ///< how often a stalled stream was woken
};

}  // namespace ovws::twin
