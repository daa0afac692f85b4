#include "bench_client.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "core/base/pixels.hpp"
#include "core/port/clock.hpp"
#include "core/tracking/tracker.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws {
namespace {

/// With a frame or a reply, which a busy machine delays.
constexpr std::chrono::seconds kPatience{60};
constexpr char kControl[] = "tcp://127.0.0.1:7790";

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().field + ": " + result.error().reason);
  return std::move(*result);
}

}  // namespace

BenchClient::BenchClient()
    : display_(must(open_sdl_display({.output = "DUMMY1"}))),
      control_(must(ControlClient::connect(kControl))) {
  open_camera();
}

BenchClient::~BenchClient() {
  stop();
}

void BenchClient::open_camera() {
  stop();
  camera_.reset();
  // A busy machine may stall this thread and the receiving one; neither may lose a frame by that.
  camera_ = must(open_aravis_camera({.id = "127.0.0.1", .buffers = 256, .receive_priority = 10}));
}

void BenchClient::start(const CameraSettings& settings) {
  stop();
  const CameraSettings applied = must(camera_->apply(settings));
  if (applied.roi != settings.roi) throw std::runtime_error("the camera did not take the ROI");
  if (auto done = camera_->start(); !done) throw std::runtime_error(done.error().reason);
  started_ = true;
}

void BenchClient::stop() {
  if (started_) camera_->stop();
  started_ = false;
}

void BenchClient::show(const SensorConfig& sensor, const std::vector<Mode>& modes) {
  HologramConfig config;
  config.sensor = sensor;
  const auto renderer = must(HologramRenderer::make(config));
  Image<std::uint8_t> grey(display_->info().width, display_->info().height);
  renderer.render(HologramKind::sensor, modes, grey);
  must(display_->present(grey));
}

TakenFrame BenchClient::grab() {
  GrabbedFrame frame;
  // Incomplete and duplicate frames are skipped.
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < give_up) {
    if (camera_->grab(frame, std::chrono::milliseconds(100)) != GrabStatus::frame) continue;
    TakenFrame taken{{frame.image.width, frame.image.height}, frame.frame_id, frame.t_device_ns};
    visit_rows(frame.image, 0, 0, frame.image.width, frame.image.height,
               [&](int x, int y, const auto* pixels, int count) {
                 std::copy_n(pixels, count, taken.dn.row(y) + x);
               });
    camera_->release(frame.slot);
    return taken;
  }
  throw std::runtime_error("no frame came within a minute");
}

TakenFrame BenchClient::newer_frame() {
  const std::int64_t now_ns = utc_ns();
  TakenFrame frame = grab();
  while (frame.t_device_ns <= now_ns) frame = grab();
  return frame;
}

Image<float> BenchClient::mean_frame(int frames) {
  Image<float> mean;
  for (int n = 0; n < frames; ++n) {
    const TakenFrame frame = n == 0 ? newer_frame() : grab();
    if (n == 0) mean = Image<float>(frame.dn.width, frame.dn.height);
    for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
      mean.pixels[i] += float(frame.dn.pixels[i]) / float(frames);
    }
  }
  return mean;
}

nlohmann::json BenchClient::call(const std::string& method, const nlohmann::json& params) {
  nlohmann::json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}};
  if (!params.is_null()) request["params"] = params;
  const std::string reply = must(control_.request(request.dump(), kPatience));
  nlohmann::json answer = nlohmann::json::parse(reply);
  return answer.contains("result") ? answer["result"] : answer;
}

Vec2 spot_at(const Image<std::uint16_t>& dn, int charge, Vec2 start_px) {
  SpotModel spots;
  spots.charge = charge;
  const auto tracker =
      must(make_tracker({.tracker = charge == 0 ? TrackerKind::weighted : TrackerKind::lg}, spots));
  TrackScratch scratch = tracker->make_scratch();
  const SpotFix fix = tracker->track(view_of(dn, PixelFormat::mono16), start_px, scratch);
  return {double(fix.x), double(fix.y)};
}

}  // namespace ovws
