/// Digital twin of the bench: owns all parts and their threads.
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "core/base/result.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/fake_camera.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/methods.hpp"
#include "drivers/twin/screen.hpp"
#include "drivers/twin/twin_config.hpp"
#include "drivers/zmq/control_server.hpp"

namespace ovws::twin {

class Twin {
 public:
  /// Starts the twin. Camera and control socket answer when this returns; the display may appear
  /// later. Errors as in FakeCamera::plug_in and ControlServer::bind.
  static Result<std::unique_ptr<Twin>> start(const Config& config, const std::string& x_display);
  ~Twin();
  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;

  std::string addresses() const;  ///< text of camera, control and SLM for the `ready` line

 private:
  Twin(const Config& config, const std::string& x_display);

  const Config config_;
  Bench bench_;
  FrameSource frames_;
  Faults faults_;
  Screen screen_;
  std::unique_ptr<FakeCamera> camera_;
  std::unique_ptr<ControlServer> control_;
  std::unique_ptr<Methods> methods_;

  // Threads are declared last, so that they end before the parts that they use. Aravis adds its own
  // thread.
  std::jthread bench_thread_, noise_thread_, screen_thread_, camera_thread_, control_thread_;
};

}  // namespace ovws::twin
