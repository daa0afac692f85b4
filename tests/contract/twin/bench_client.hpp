/// Client of a running twin: shows holograms on its SLM, grabs frames of its camera, and calls its
/// control socket, all with the project's own drivers.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/port/display.hpp"
#include "drivers/zmq/client.hpp"

namespace ovws {

/// A copy of a frame that outlives its buffer.
struct TakenFrame {
  Image<std::uint16_t> dn;
  std::uint64_t frame_id = 0;
  std::int64_t t_device_ns = 0;
};

/// Throws std::runtime_error if the bench fails.
class BenchClient {
 public:
  BenchClient();
  ~BenchClient();

  Display& display() { return *display_; }
  Camera& camera() { return *camera_; }
  void open_camera();
  void start(const CameraSettings& settings);
  void stop();

  /// Shows the sensor's hologram. The X server has it when this returns.
  void show(const SensorConfig& sensor, const std::vector<Mode>& modes = {});

  TakenFrame grab();         ///< the next frame; throws if none comes within a minute
  TakenFrame newer_frame();  ///< the first frame that the twin begins after this call
  /// Mean of several frames, all begun after this call.
  Image<float> mean_frame(int frames);

  nlohmann::json call(const std::string& method, const nlohmann::json& params = nullptr);

 private:
  std::unique_ptr<Display> display_;
  std::unique_ptr<Camera> camera_;
  ControlClient control_;
  bool started_ = false;
};

/// Position of the spot near `start_px` by the tracker for this charge; NaN if lost.
Vec2 spot_at(const Image<std::uint16_t>& dn, int charge, Vec2 start_px);

}  // namespace ovws
