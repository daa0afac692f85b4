/// Camera port on Aravis: combines GenicamDevice, CameraFeatures and AravisStream.
#include "drivers/aravis/aravis_camera.hpp"

#include <optional>
#include <utility>

#include "drivers/aravis/features.hpp"
#include "drivers/aravis/frame_id.hpp"
#include "drivers/aravis/genicam_device.hpp"
#include "drivers/aravis/listing.hpp"
#include "drivers/aravis/stream.hpp"

namespace ovws {

namespace {

constexpr const char* kField = "camera.id";

struct Listing {
  std::string address;
  bool gige = false;
};

/// Looks up the camera that has this Aravis device id or serial number.
Result<Listing> look_up(const std::string& id) {
  const auto cameras = list_cameras();
  if (const ListedCamera* const camera = find_listed(cameras, id)) {
    const bool by_address = camera->gige && !camera->address.empty();
    return Listing{by_address ? camera->address : camera->id, camera->gige};
  }
  const std::string found = names_of(cameras);
  return fail(Errc::unavailable, kField,
              "no camera has the id or serial number " + id + "; " +
                  (found.empty() ? "no camera was found at all; check cable, power and network"
                                 : "cameras found: " + found));
}

struct FoundDevice {
  GRef<ArvDevice> device;
  std::string address;  ///< IP address, or name of the USB device
};

/// Finds and opens the camera by its address. An IP address is used directly; a device id or serial
/// number is looked up first, which takes about 1 s. Errc::unavailable, field "camera.id", after at
/// most about 6 s if no camera answers (an unknown id lists the cameras found) or another program
/// controls the camera. Errc::invalid if `id` is empty.
Result<FoundDevice> find_device(const std::string& id) {
  if (id.empty())
    return fail(Errc::invalid, kField,
                "is empty: give the camera's IP address, id or serial number");
  Listing listing{id, true};
  if (!g_hostname_is_ip_address(id.c_str())) {
    auto listed = look_up(id);
    if (!listed) return fail(listed.error());
    listing = *listed;
  }
  GErrorSlot error;
  // GigE cameras: open through the GigE interface only. arv_open_device would search all USB
  // devices first.
  GRef<ArvDevice> device(listing.gige
                             ? arv_interface_open_device(arv_gv_interface_get_instance(),
                                                         listing.address.c_str(), error.out())
                             : arv_open_device(listing.address.c_str(), error.out()));
  if (!device)
    return fail(Errc::unavailable, kField,
                "no camera answers at " + listing.address + "; check its cable, power and address");
  if (ARV_IS_GV_DEVICE(device.get()) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device.get())))
    return fail(Errc::unavailable, kField,
                "the camera at " + listing.address +
                    " is controlled by another program; close it, or wait a few seconds if it has "
                    "just ended");
  return FoundDevice{std::move(device), listing.address};
}

class AravisCamera final : public Camera {
 public:
  AravisCamera(const AravisConfig& config, FoundDevice found)
      : config_(config), device_(std::move(found.device)), ids_(id_width(device_)) {
    info_.address = std::move(found.address);
  }
  AravisCamera(const AravisCamera&) = delete;
  AravisCamera& operator=(const AravisCamera&) = delete;
  ~AravisCamera() override { AravisCamera::stop(); }

  /// Configures the opened camera and reads its settings; then `start` is possible.
  Result<void> set_up() {
    // A crashed client may have left the acquisition running; then a new start gives no frames.
    if (auto stopped = device_.execute("AcquisitionStop"); !stopped) return stopped;
    auto features = CameraFeatures::find(device_);
    if (!features) return fail(features.error());
    features_.emplace(*features);
    if (auto done = features_->prepare(config_.trigger); !done) return done;
    if (auto done = prepare_transport(device_, config_); !done) return done;
    auto current = features_->read();
    if (!current) return fail(current.error());
    current_ = *current;
    info_ = features_->info(info_.address);
    return {};
  }

  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override { return features_->limits(); }

  Result<CameraSettings> apply(const CameraSettings& wanted) override {
    auto applied = features_->apply(wanted, current_, stream_ != nullptr);
    if (applied) current_ = *applied;
    return applied;
  }

  Result<void> start() override {
    if (stream_)
      return fail(Errc::refused, "", "program error: the camera was started twice; restart ovwsd");
    ids_.restart();
    const FrameShape shape{current_.roi.width, current_.roi.height, current_.pixel_format};
    auto stream = AravisStream::open(device_, config_, shape, ids_);
    if (!stream) return fail(stream.error());
    if (auto started = device_.execute("AcquisitionStart"); !started) return started;
    stream_ = std::move(*stream);
    return {};
  }

  void stop() override {
    if (!stream_) return;
    // AcquisitionStop errors are ignored: the next `start` or `apply` reports them.
    (void)device_.execute("AcquisitionStop");
    stream_.reset();
  }

  bool alive() const override { return device_.alive(); }
  int buffer_count() const override { return config_.buffers; }

  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) override {
    return stream_ ? stream_->grab(out, timeout) : GrabStatus::timeout;
  }
  void release(int slot) OVWS_NONBLOCKING override {
    if (stream_) stream_->release(slot);
  }

 private:
  static FrameIdUnwrapper::Width id_width(GenicamDevice& device) {
    using Width = FrameIdUnwrapper::Width;
    if (!device.is_gige()) return Width::bits64;
    const char* mode = "GevGVSPExtendedIDMode";
    return device.has(mode) && device.text(mode).value_or("") == "On" ? Width::bits64
                                                                      : Width::bits16;
  }

  AravisConfig config_;
  CameraInfo info_;
  GenicamDevice device_;
  std::optional<CameraFeatures> features_;
  CameraSettings current_;
  FrameIdUnwrapper ids_;
  std::unique_ptr<AravisStream> stream_;
};

}  // namespace

Result<std::unique_ptr<Camera>> open_aravis_camera(const AravisConfig& config) {
  if (config.buffers < 2) return fail(Errc::invalid, "camera.buffers", "must be at least 2");
  auto found = find_device(config.id);
  if (!found) return fail(found.error());
  auto camera = std::make_unique<AravisCamera>(config, std::move(*found));
  if (auto ready = camera->set_up(); !ready) return fail(ready.error());
  return camera;
}

}  // namespace ovws
