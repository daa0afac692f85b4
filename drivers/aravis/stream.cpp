/// Acquisition stream: buffers, their way between Aravis and the caller, and transport settings.
#include "drivers/aravis/stream.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "core/port/clock.hpp"
#include "drivers/aravis/udp_socket.hpp"

namespace ovws {

namespace {

std::size_t round_up(std::size_t size, std::size_t unit) {
  return (size + unit - 1) / unit * unit;
}

/// GVSP packets per frame, including leader and trailer; 1 for USB3. The headers of IP, UDP and
/// GVSP take 36 bytes of each packet.
std::uint64_t packets_per_frame(GenicamDevice& device, std::size_t payload_bytes) {
  constexpr std::size_t kHeaders = 36;
  if (!device.is_gige()) return 1;
  const std::size_t size = arv_gv_device_get_packet_size(ARV_GV_DEVICE(device.raw()), nullptr);
  const std::size_t data = size > kHeaders ? size - kHeaders : 1;
  return (payload_bytes + data - 1) / data + 2;
}

/// Sets the receive thread's priority. Aravis calls this in that thread: at its start and end, and
/// for each frame.
void set_priority(void* priority, ArvStreamCallbackType type, ArvBuffer* /*buffer*/) {
  if (type != ARV_STREAM_CALLBACK_TYPE_INIT) return;
  sched_param parameters{};
  parameters.sched_priority = GPOINTER_TO_INT(priority);
  if (parameters.sched_priority > 0) {
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  }
}

/// Whether the socket's receive buffer holds enough frames. If it does, frames come through it at
/// once. Otherwise they come through Aravis's packet socket, if CAP_NET_RAW allows that: it holds
/// 32 MiB, but the kernel hands its blocks of 2 MiB over every 5 ms only.
bool fits_socket_buffer(std::size_t payload_bytes, int wanted_bytes) {
  constexpr std::size_t kFrames = 8;
  const UdpSocket probe;
  int granted_bytes = 0;  // twice the wanted size, because the kernel needs memory for each packet
  socklen_t size = sizeof(granted_bytes);
  (void)setsockopt(probe.get(), SOL_SOCKET, SO_RCVBUF, &wanted_bytes, sizeof(wanted_bytes));
  const bool known = getsockopt(probe.get(), SOL_SOCKET, SO_RCVBUF, &granted_bytes, &size) == 0;
  return known && std::size_t(granted_bytes) / 2 >= kFrames * payload_bytes;
}

}  // namespace

Result<void> prepare_transport(GenicamDevice& device, const AravisConfig& config) {
  if (ARV_IS_UV_DEVICE(device.raw()))
    arv_uv_device_set_usb_mode(ARV_UV_DEVICE(device.raw()), ARV_UV_USB_MODE_ASYNC);
  if (!device.is_gige() || config.packet_size_bytes == 0) return {};
  // When the first stream is created, Aravis requests a test packet of this size, if the camera can
  // send test packets. If the packet does not arrive, Aravis uses a smaller size.
  auto sizes = device.range("GevSCPSPacketSize");
  if (!sizes) return fail(sizes.error());
  if (config.packet_size_bytes < sizes->min)
    return fail(Errc::invalid, "camera.packet_size_bytes",
                "must be at least " + std::to_string(int(sizes->min)) + " bytes for this camera");
  const double step = std::max(sizes->increment, 1.0);
  const double capped = std::min(double(config.packet_size_bytes), sizes->max);
  return device.set_number("ArvGevSCPSPacketSize",
                           sizes->min + std::floor((capped - sizes->min) / step) * step);
}

Result<std::unique_ptr<AravisStream>> AravisStream::open(GenicamDevice& device,
                                                         const AravisConfig& config,
                                                         const FrameShape& shape,
                                                         FrameIdUnwrapper& ids) {
  auto payload = device.number("PayloadSize");
  if (!payload) return fail(payload.error());
  GErrorSlot error;
  const int priority = device.is_gige() ? config.receive_priority : 0;
  if (device.is_gige()) {
    const bool fits = fits_socket_buffer(std::size_t(*payload), config.socket_buffer_bytes);
    arv_gv_device_set_stream_options(
        ARV_GV_DEVICE(device.raw()),
        fits ? ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED : ARV_GV_STREAM_OPTION_NONE);
  }
  GRef<ArvStream> stream(
      arv_device_create_stream(device.raw(), set_priority, GINT_TO_POINTER(priority), error.out()));
  if (!stream) return fail(error.to_error(Errc::device, "opening the stream"));
  // The UDP socket's default receive buffer is so small that all frames would be lost. Packet
  // resend stays on (Aravis's default).
  if (ARV_IS_GV_STREAM(stream.get()))
    g_object_set(stream.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", config.socket_buffer_bytes, nullptr);

  const StrayFrames strays(packets_per_frame(device, std::size_t(*payload)));
  std::unique_ptr<AravisStream> self(new AravisStream(std::move(stream), shape, ids, strays));
  if (!self->allocate(std::size_t(*payload), config.buffers))
    return fail(Errc::unavailable, "camera.roi",
                "not enough memory for " + std::to_string(config.buffers) + " frames of " +
                    std::to_string(std::size_t(*payload)) + " bytes; make the region smaller");
  return self;
}

AravisStream::AravisStream(GRef<ArvStream> stream, const FrameShape& shape, FrameIdUnwrapper& ids,
                           const StrayFrames& strays)
    : shape_(shape),
      ids_(&ids),
      strays_(strays),
      packets_(packet_counts(stream.get())),
      stream_(std::move(stream)) {}

AravisStream::~AravisStream() {
  requeue_released();
}

bool AravisStream::allocate(std::size_t payload_bytes, int count) {
  const auto page = std::size_t(sysconf(_SC_PAGESIZE));
  const std::size_t pitch = round_up(payload_bytes, page);
  if (pitch == 0) return false;
  const std::size_t total = pitch * std::size_t(count);
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(page, total)));
  if (!memory_) return false;
  // Write all pages now (pre-fault), so that the receive path has no page faults.
  std::memset(memory_.get(), 0, total);
  lent_.assign(std::size_t(count), nullptr);
  released_.reserve(std::size_t(count));
  for (int slot = 0; slot < count; ++slot)
    arv_stream_push_buffer(stream_.get(),
                           arv_buffer_new_full(payload_bytes, memory_.get() + pitch * slot,
                                               GINT_TO_POINTER(slot), nullptr));
  return true;
}

void AravisStream::requeue_released() {
  for (ArvBuffer* buffer : released_) arv_stream_push_buffer(stream_.get(), buffer);
  released_.clear();
}

bool AravisStream::view_image(ArvBuffer* buffer, ImageView& image) const {
  if (arv_buffer_get_payload_type(buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE) return false;
  gint width = 0;
  gint height = 0;
  arv_buffer_get_image_region(buffer, nullptr, nullptr, &width, &height);
  if (width != shape_.width || height != shape_.height) return false;
  gint padding = 0;
  arv_buffer_get_image_padding(buffer, &padding, nullptr);
  std::size_t size = 0;
  image.data = static_cast<const std::byte*>(arv_buffer_get_image_data(buffer, &size));
  image.width = width;
  image.height = height;
  image.stride_bytes = std::ptrdiff_t(row_bytes(shape_.format, width)) + padding;
  image.format = shape_.format;
  image.left_justified_bits = 0;
  return size >= std::size_t(image.stride_bytes) * std::size_t(height) - std::size_t(padding);
}

std::optional<AravisStream::PacketCounts> AravisStream::packet_counts(ArvStream* stream) {
  const auto number = [stream](std::string_view name) -> std::optional<guint> {
    for (guint id = 0; id < arv_stream_get_n_infos(stream); ++id) {
      if (name == arv_stream_get_info_name(stream, id)) return id;
    }
    return std::nullopt;
  };
  const auto ignored = number("n_ignored_packets"), without_buffer = number("n_underruns");
  if (!ignored || !without_buffer) return std::nullopt;
  return PacketCounts{*ignored, *without_buffer};
}

void AravisStream::count_strays() {
  if (!packets_) return;
  // Subtract packets for which no buffer was free: their frames are lost, not duplicate or late.
  const std::uint64_t ignored = arv_stream_get_info_uint64(stream_.get(), packets_->ignored);
  const std::uint64_t without_buffer =
      arv_stream_get_info_uint64(stream_.get(), packets_->without_buffer);
  const auto counts = strays_.discarded(ignored - std::min(ignored, without_buffer));
  unreported_.duplicate += counts.duplicate;
  unreported_.out_of_order += counts.out_of_order;
}

/// Reports the next discarded frame not yet reported; GrabStatus::timeout if none is left.
GrabStatus AravisStream::stray() {
  if (unreported_.out_of_order > 0) {
    --unreported_.out_of_order;
    return GrabStatus::out_of_order;
  }
  if (unreported_.duplicate == 0) return GrabStatus::timeout;
  --unreported_.duplicate;
  return GrabStatus::duplicate;
}

GrabStatus AravisStream::grab(GrabbedFrame& out, std::chrono::microseconds timeout) {
  requeue_released();
  if (const GrabStatus status = stray(); status != GrabStatus::timeout) return status;
  ArvBuffer* buffer = timeout.count() > 0 ? arv_stream_timeout_pop_buffer(
                                                stream_.get(), std::uint64_t(timeout.count()))
                                          : arv_stream_try_pop_buffer(stream_.get());
  if (!buffer) {
    count_strays();
    return stray();
  }
  out.t_arrival_mono_ns = monotonic_ns();
  out.t_arrival_ns = utc_ns();
  const bool is_first = std::exchange(awaits_first_, false);
  if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS ||
      !view_image(buffer, out.image)) {
    arv_stream_push_buffer(stream_.get(), buffer);
    strays_.delivered_incomplete();
    // Aravis sets the size of the socket's buffer with the first packet, too late for the others of
    // that frame.
    return is_first ? grab(out, timeout) : GrabStatus::incomplete;
  }
  out.frame_id = ids_->next(arv_buffer_get_frame_id(buffer));
  strays_.delivered(out.frame_id);
  count_strays();
  out.t_device_ns = std::int64_t(arv_buffer_get_timestamp(buffer));
  out.slot = GPOINTER_TO_INT(arv_buffer_get_user_data(buffer));
  lent_[std::size_t(out.slot)] = buffer;
  return GrabStatus::frame;
}

void AravisStream::release(int slot) OVWS_NONBLOCKING {
  ArvBuffer* const buffer = std::exchange(lent_[std::size_t(slot)], nullptr);
  if (buffer) released_.push_back(buffer);
}

}  // namespace ovws
