/// An agent: a duty cycle that some thread of the thread table turns.
#pragma once

namespace ovws {

class Agent {
 public:
  virtual ~Agent() = default;
  /// One turn. Returns true if something was done. May wait inside only for its own input, and at
  /// most 50 ms, so that a stop request is seen in time.
  virtual bool do_work() = 0;
  /// Called once by the same thread before it ends.
  virtual void on_close() {}
};

}  // namespace ovws
