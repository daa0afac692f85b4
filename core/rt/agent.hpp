/// An agent: a duty cycle that a thread of the thread table runs in a loop.
#pragma once

namespace ovws {

class Agent {
 public:
  virtual ~Agent() = default;
  /// One iteration of the duty cycle. Returns true if it did any work. It may block only for its
  /// own input and for at most 50 ms, so that the thread sees a stop request in time.
  virtual bool do_work() = 0;
  /// Called once by the same thread before it ends.
  virtual void on_close() {}
};

}  // namespace ovws
