/// The last stage: spots -> modes, and whether the result may be believed.
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

  /// Frames in order, by one thread at a time. The record is handed on: not to be touched after.
  void run(Entry& entry) OVWS_NONBLOCKING;

 private:
  Deps deps_;
};

}  // namespace ovws
