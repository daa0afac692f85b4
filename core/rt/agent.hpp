/// Agent: work that a thread of the daemon runs in a loop (a duty cycle).
#pragma once

namespace ovws {

class Agent {
 public:
  virtual ~Agent() = default;
  /// Runs one iteration of the duty cycle and returns true if any work was done. Waits for input
  /// for at most 50 ms, so that the thread notices a stop request in time. All else that it may
  /// wait for is in the daemon's table of threads.
  virtual bool do_work() = 0;
  /// Clean-up: the thread that runs do_work calls this once before it ends.
  virtual void on_close() {}
};

}  // namespace ovws
