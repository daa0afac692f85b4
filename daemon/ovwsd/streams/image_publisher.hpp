/// The image publisher: sends camera images and phase maps at a display rate, and serves the
/// taps that need pixels.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/wavefront/phase_map.hpp"
#include "daemon/ovwsd/frames/frame_grabs.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "daemon/ovwsd/frames/image_brightness.hpp"
#include "drivers/zmq/publisher.hpp"

namespace ovws {

/// Agent of the images thread.
class ImagePublisher : public Agent {
 public:
  /// `rate_hz`: as for set_rate. `frames`, `grabs` and `brightness` must outlive this object. Taps
  /// for pixels are served between two images, and `grabs` are ended; `brightness` looks at each
  /// image that is sent.
  ImagePublisher(Publisher socket, double wavelength_nm, double rate_hz, Pipeline& pipeline,
                 Counters& counters, FrameTaps& frames, FrameGrabs& grabs,
                 ImageBrightness& brightness);

  bool do_work() override;
  std::uint64_t sent() const { return sent_.load(); }  ///< Thread-safe.
  const ImageBrightness& brightness() const { return brightness_; }
  /// Sets the rate of images and phase maps, in Hz; 0: none are sent. Thread-safe.
  void set_rate(double rate_hz) { rate_hz_.store(rate_hz); }

 private:
  double wait_ns() const;
  void serve(const FrameRecord& record);
  void send(const FrameRecord& record);
  void send_image(const FrameRecord& record);
  void send_phase(const FrameRecord& record);

  Publisher socket_;
  const double wavelength_nm_;
  Pipeline& pipeline_;
  Counters& counters_;
  FrameTaps& frames_;
  FrameGrabs& grabs_;
  ImageBrightness& brightness_;
  std::atomic<double> rate_hz_;
  std::int64_t sent_ns_ = std::numeric_limits<std::int64_t>::min() / 2;  ///< long ago: none yet
  bool requested_ = false;
  std::atomic<std::uint64_t> sent_{0};
  std::uint64_t image_seq_ = 0, phase_seq_ = 0;
  std::unique_ptr<PhaseMap> phase_map_;
  std::vector<int> phase_modes_j_;
  Image<float> phase_waves_;
  std::string json_;
  std::vector<std::byte> binary_;
};

}  // namespace ovws
