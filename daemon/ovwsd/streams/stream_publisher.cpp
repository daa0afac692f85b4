#include "daemon/ovwsd/streams/stream_publisher.hpp"

#include <array>
#include <memory>
#include <utility>

#include "core/port/clock.hpp"
#include "proto/encode.hpp"

namespace ovws {
namespace {

constexpr int kTurnUs = 5000;

}  // namespace

FrameMessage frame_message(const FrameRecord& record, double wavelength_nm) {
  const MeasurementPlan& plan = *record.plan;
  FrameMessage message;
  message.frame_id = record.frame.frame_id;
  message.gap = record.gap;
  message.t_device_ns = record.frame.t_device_ns;
  message.t_arrival_ns = record.frame.t_arrival_ns;
  message.hologram_id = record.hologram_id;
  message.settled = record.settled;
  if (record.pattern >= 0) message.pattern = record.pattern;
  message.charge = plan.charge;
  message.tracker = tracker_name(record.templates.credible ? TrackerKind::fit : plan.tracker_kind);
  message.subapertures = record.spot_count;
  message.tracked = record.tracked;
  message.valid = record.valid;
  message.verdict = record.verdict;
  message.wavelength_nm = wavelength_nm;
  if (record.valid) message.rms_waves = record.reconstruction.rms_waves;
  if (record.valid || !record.explained) {
    message.fit_residual_px = record.reconstruction.fit_residual_px;
  }
  if (record.settings_known) {
    message.gain_db = record.gain_db;
    message.gain_raw = record.gain_raw;
    message.exposure_us = record.exposure_us;
  }
  message.saturated = record.saturated_fraction;
  message.reference_introduced_rms_waves = plan.reference_introduced_rms_waves;
  return message;
}

StreamPublisher::StreamPublisher(Publisher socket, double wavelength_nm, StreamPublisherDeps deps)
    : socket_(std::move(socket)), wavelength_nm_(wavelength_nm), deps_(std::move(deps)) {}

bool StreamPublisher::do_work() {
  FrameRecord* record = deps_.pipeline.next(kTurnUs);
  if (record != nullptr) {
    const auto release = [this](FrameRecord* one) { deps_.pipeline.release(one); };
    const std::unique_ptr<FrameRecord, decltype(release)> held(record, release);
    send_frame(*record);
    deps_.frames.serve_numbers(*record);
  }
  send_queue();
  return record != nullptr;
}

void StreamPublisher::on_close() {
  while (!deps_.queue.is_empty()) send_queue();
}

void StreamPublisher::send_frame(const FrameRecord& record) {
  FrameMessage frame = frame_message(record, wavelength_nm_);
  frame.loop_closed = deps_.loop_closed();
  send_commands(record, frame);
  send_record(record, frame);
  for (const FrameRecord* const beam : record.beams()) {
    FrameMessage own = frame_message(*beam, wavelength_nm_);
    own.loop_closed = frame.loop_closed;
    send_record(*beam, own);
  }
  ++wavefront_seq_;
  ++spots_seq_;
}

/// The topic of one light source.
std::string_view StreamPublisher::topic(std::string_view name, const FrameRecord& of) {
  const std::string& beam = of.plan->beam;
  if (beam.empty()) return name;
  topic_.assign(name).append(1, '.').append(beam);
  return topic_;
}

void StreamPublisher::send_record(const FrameRecord& record, const FrameMessage& frame) {
  WavefrontMessage wavefront;
  static_cast<FrameMessage&>(wavefront) = frame;
  stamp(record, wavefront);
  SpotsMessage spots;
  static_cast<FrameMessage&>(spots) = wavefront;

  wavefront.seq = wavefront_seq_;
  wavefront.j = record.plan->modes_j;
  wavefront.coefficients = std::span(record.coefficients).first(std::size_t(record.mode_count));
  wavefront.sigma = std::span(record.sigma_waves).first(std::size_t(record.mode_count));
  wavefront.fitted = record.templates.credible;
  std::array<BranchPointEntry, kMaxBranchPoints> branch_points;
  for (int k = 0; k < record.branch_points.count; ++k) {
    const BranchPoint& one = record.branch_points.points[std::size_t(k)];
    branch_points[std::size_t(k)] = {one.at.x, one.at.y, double(one.charge)};
  }
  wavefront.branch_points = std::span(branch_points).first(std::size_t(record.branch_points.count));
  encode(wavefront, json_);
  send(topic(kTopicWavefront, record));
  if (record.plan->beam.empty()) {
    deps_.published_latency.record(monotonic_ns() - record.frame.t_arrival_mono_ns);
  }

  spots.seq = spots_seq_;
  spots.spots = std::span(record.spots).first(std::size_t(record.spot_count));
  spots.reference_px = record.plan->reference_px;
  send(topic(kTopicSpots, record), encode(spots, json_, binary_));
}

/// Commands come first, because a loop waits for them.
void StreamPublisher::send_commands(const FrameRecord& record, const FrameMessage& frame) {
  const CorrectorMatrix* const matrix = deps_.corrector.matrix();
  if (matrix == nullptr) return;
  CorrectorMessage message;
  static_cast<FrameMessage&>(message) = frame;
  message.matrix = matrix->number;
  message.commands = deps_.corrector.commands(*matrix, record);
  message.valid = !message.commands.empty();
  message.seq = corrector_seq_++;
  stamp(record, message);
  send(kTopicCorrector, encode(message, json_));
}

void StreamPublisher::stamp(const FrameRecord& record, FrameMessage& message) const {
  message.latency_us = double(monotonic_ns() - record.frame.t_arrival_mono_ns) / 1000.0;
  message.t_publish_ns = utc_ns();
}

void StreamPublisher::send_queue() {
  if (const auto dropped = deps_.queue.take_dropped(); dropped > 0) {
    deps_.counters.add(Counter::messages_dropped, dropped);
  }
  while (auto message = deps_.queue.take()) {
    if (const auto* event = std::get_if<EventMessage>(&*message)) {
      json_ = encode(*event);
      send(kTopicEvent);
    } else if (auto* refined = std::get_if<RefinedMessage>(&*message)) {
      refined->t_publish_ns = utc_ns();
      json_ = encode(*refined);
      send(kTopicRefined);
    } else if (const auto* status = std::get_if<StatusMessage>(&*message)) {
      json_ = encode(*status);
      send(kTopicStatus);
    }
  }
}

void StreamPublisher::send(std::string_view topic, std::span<const std::byte> binary) {
  if (!socket_.send(topic, json_, binary)) deps_.counters.add(Counter::messages_dropped);
}

}  // namespace ovws
