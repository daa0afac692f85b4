#include "daemon/ovwsd/streams/image_publisher.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <thread>

#include "core/port/clock.hpp"
#include "proto/encode.hpp"

namespace ovws {
namespace {

constexpr int kPhaseSizePx = 128;
constexpr std::int64_t kTurnNs = 50'000'000;
constexpr double kPauseNs = 1e7;  // between two checks for open requests

}  // namespace

ImagePublisher::ImagePublisher(Publisher socket, double wavelength_nm, double rate_hz,
                               Pipeline& pipeline, Counters& counters, FrameTaps& frames,
                               FrameGrabs& grabs, ImageBrightness& brightness)
    : socket_(std::move(socket)),
      wavelength_nm_(wavelength_nm),
      pipeline_(pipeline),
      counters_(counters),
      frames_(frames),
      grabs_(grabs),
      brightness_(brightness),
      rate_hz_(rate_hz) {}

/// Time until the next image is due; infinite: none is sent.
double ImagePublisher::wait_ns() const {
  const double rate_hz = rate_hz_.load();
  const double period_ns = rate_hz > 0.0 ? 1e9 / rate_hz : std::numeric_limits<double>::infinity();
  return period_ns - double(monotonic_ns() - sent_ns_);
}

bool ImagePublisher::do_work() {
  grabs_.end_due();
  const double wait = wait_ns();
  if (!requested_ && !frames_.wants_pixels() && wait > 0.0) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::int64_t(std::min(wait, kPauseNs))));
    return false;
  }
  if (!requested_) pipeline_.request_image();
  requested_ = true;
  FrameRecord* record = pipeline_.next_image(int(kTurnNs / 1000));
  if (record == nullptr) return false;
  requested_ = false;
  const auto release = [this](FrameRecord* one) { pipeline_.release_image(one); };
  const std::unique_ptr<FrameRecord, decltype(release)> held(record, release);
  serve(*record);
  grabs_.end_due();
  if (wait_ns() <= 0.0) {
    sent_ns_ = monotonic_ns();
    send(*record);
  }
  return true;
}

void ImagePublisher::serve(const FrameRecord& record) {
  try {
    frames_.serve_pixels(record);
  } catch (const std::bad_alloc&) {
    counters_.add(Counter::messages_dropped);  // the request that ran out of memory stays open
  }
}

void ImagePublisher::send(const FrameRecord& record) {
  send_image(record);
  send_phase(record);
  brightness_.look(record.frame.image, monotonic_ns());
  sent_.fetch_add(1);
}

void ImagePublisher::send_image(const FrameRecord& record) {
  ImageMessage message;
  message.seq = image_seq_++;
  message.frame_id = record.frame.frame_id;
  message.hologram_id = record.hologram_id;
  if (record.pattern >= 0) message.pattern = record.pattern;
  message.t_arrival_ns = record.frame.t_arrival_ns;
  message.image = record.frame.image;
  const auto binary = encode(message, json_, binary_);
  if (!socket_.send(kTopicImage, json_, binary)) counters_.add(Counter::messages_dropped);
}

void ImagePublisher::send_phase(const FrameRecord& record) {
  const auto& modes_j = record.plan->modes_j;
  if (!phase_map_ || modes_j != phase_modes_j_) {
    phase_modes_j_ = modes_j;
    phase_map_ = std::make_unique<PhaseMap>(modes_j, kPhaseSizePx);
  }
  PhaseMessage message;
  message.seq = phase_seq_++;
  message.frame_id = record.frame.frame_id;
  message.hologram_id = record.hologram_id;
  message.t_arrival_ns = record.frame.t_arrival_ns;
  message.valid = record.valid;
  message.wavelength_nm = wavelength_nm_;
  phase_map_->render(std::span(record.coefficients).first(std::size_t(record.mode_count)),
                     phase_waves_);
  if (!record.valid) {
    std::fill(phase_waves_.pixels.begin(), phase_waves_.pixels.end(),
              std::numeric_limits<float>::quiet_NaN());
  }
  message.waves = &phase_waves_;
  const auto binary = encode(message, json_);
  if (!socket_.send(kTopicPhase, json_, binary)) counters_.add(Counter::messages_dropped);
}

}  // namespace ovws
