/// The fault slow_registers: Aravis's fake camera has no place for it, so it is put where the
/// camera sends its answers.
#pragma once

#include "drivers/twin/faults.hpp"

namespace ovws::twin {

/// While it lives, write acknowledgements wait as long as these faults say. One at a time.
class SlowRegisters {
 public:
  explicit SlowRegisters(const Faults& faults);
  ~SlowRegisters();
  SlowRegisters(const SlowRegisters&) = delete;
  SlowRegisters& operator=(const SlowRegisters&) = delete;
};

}  // namespace ovws::twin
