/// The fault slow_registers. Aravis's fake camera has no hook for it, so it interposes the function
/// that sends the camera's packets.
#pragma once

#include "drivers/twin/faults.hpp"

namespace ovws::twin {

/// While this object exists, write acknowledges are delayed as ordered in `faults`. One at a time.
class SlowRegisters {
 public:
  explicit SlowRegisters(const Faults& faults);
  ~SlowRegisters();
  SlowRegisters(const SlowRegisters&) = delete;
  SlowRegisters& operator=(const SlowRegisters&) = delete;
};

}  // namespace ovws::twin
