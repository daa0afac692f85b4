/// The publisher of the measurement stream: sends commands, wavefront and spots of each frame,
/// serves the taps that need numbers, and sends the queued event, status and refined messages.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latency_histogram.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "daemon/ovwsd/streams/corrector.hpp"
#include "drivers/zmq/publisher.hpp"
#include "proto/messages.hpp"

namespace ovws {

struct StreamPublisherDeps {
  Pipeline& pipeline;
  FrameTaps& frames;
  std::function<bool()> loop_closed;  ///< called in the publish thread
  Corrector& corrector;
  Counters& counters;
  StreamQueue& queue;
  LatencyHistogram& published_latency;
};

/// Frame fields that the `wavefront`, `spots` and `corrector` messages have in common, except `seq`
/// and the publish times.
FrameMessage frame_message(const FrameRecord& record, double wavelength_nm);

/// Agent of the publish thread. No other thread uses the socket.
class StreamPublisher : public Agent {
 public:
  StreamPublisher(Publisher socket, double wavelength_nm, StreamPublisherDeps deps);

  bool do_work() override;
  /// Sends the messages still queued, so that the last events are not lost.
  void on_close() override;

 private:
  void send_frame(const FrameRecord& record);
  void send_record(const FrameRecord& record, const FrameMessage& frame);
  std::string_view topic(std::string_view name, const FrameRecord& of);
  void send_commands(const FrameRecord& record, const FrameMessage& frame);
  void stamp(const FrameRecord& record, FrameMessage& message) const;
  void send_queue();
  void send(std::string_view topic, std::span<const std::byte> binary = {});

  Publisher socket_;
  double wavelength_nm_;
  StreamPublisherDeps deps_;
  /// Of the next message; the topics of all light sources count alike.
  std::uint64_t wavefront_seq_ = 0, spots_seq_ = 0, corrector_seq_ = 0;
  std::string json_, topic_;
  std::vector<std::byte> binary_;
};

}  // namespace ovws
