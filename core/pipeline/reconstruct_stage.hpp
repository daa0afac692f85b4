/// Last pipeline stage: reconstructs the modes from the spots and decides whether they are valid.
#pragma once

#include "core/base/realtime.hpp"
#include "core/pipeline/outbox.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/rt/latency_histogram.hpp"

namespace ovws {

class ReconstructStage {
 public:
  struct Deps {
    LatencyHistogram& latency;
    Outbox& outbox;
  };

  explicit ReconstructStage(const Deps& deps) : deps_(deps) {}

  /// Frames in order, one thread at a time. Passes the record on; do not use it afterwards.
  void run(Entry& entry) OVWS_NONBLOCKING;

 private:
  Deps deps_;
};

}  // namespace ovws
