/// Fault slow_registers: delays register acknowledges. Aravis's fake camera has no hook for this,
/// so the function that sends the camera's packets is interposed.
#pragma once

#include "drivers/twin/faults.hpp"

namespace ovws::twin {

/// Delays write acknowledges while this object exists and `faults` has slow_registers active. Only
/// one object may exist at a time.
class SlowRegisters {
 public:
  explicit SlowRegisters(const Faults& faults);
  ~SlowRegisters();
  SlowRegisters(const SlowRegisters&) = delete;
  SlowRegisters& operator=(const SlowRegisters&) = delete;
};

}  // namespace ovws::twin
