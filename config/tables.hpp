/// Field tables of the configuration file, in the order of ovwsd.json.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "proto/endpoint.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/optics.hpp"
#include "proto/tables/refine.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

inline std::optional<std::string> is_empty(const std::string& text) {
  return text.empty() ? std::optional<std::string>("must not be empty") : std::nullopt;
}
inline std::optional<std::string> is_empty_path(const std::optional<std::string>& path) {
  return path ? is_empty(*path) : std::nullopt;
}
inline std::optional<std::string> is_no_endpoint(const std::string& text) {
  return endpoint_fault(text);
}
inline std::optional<std::string> is_no_power_of_two(const int& number) {
  if ((number & (number - 1)) == 0) return std::nullopt;
  return "must be a power of two, not " + std::to_string(number);
}

template <>
struct Names<RealtimePolicy> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"enforce", "ignore"};
    return names;
  }
};

template <>
struct Names<LogLevel> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"trace", "debug", "info", "warn", "error"};
    return names;
  }
};

template <>
struct Table<CameraConfig> {
  static constexpr const char* kName = "CameraConfig";
  static constexpr auto kFields =
      Fields{field("driver", &CameraConfig::driver, "which camera driver").checked(is_empty),
             field("id", &CameraConfig::id, "GenICam id or address").checked(is_empty),
             inlined(&CameraConfig::settings),
             field("packet_size_bytes", &CameraConfig::packet_size_bytes,
                   "GigE Vision packet size, bytes", limits::kPacketSizeBytes),
             field("transfer_ms", &CameraConfig::transfer_ms,
                   "longest time from the end of an exposure to the frame's arrival, milliseconds",
                   limits::kTransferMs)};
};

template <>
struct Table<SlmConfig> {
  static constexpr const char* kName = "SlmConfig";
  static constexpr auto kFields = Fields{
      field("driver", &SlmConfig::driver, "which display driver").checked(is_empty),
      field("display", &SlmConfig::display, "name of the output, e.g. HDMI-1").checked(is_empty),
      inlined(&SlmConfig::geometry),
      field("lut", &SlmConfig::lut, "look-up table: file of 256 grey levels; null: linear"),
      field("flatness", &SlmConfig::flatness,
            "flatness map: file of the phase to add at each pixel; null: none"),
      field("settle_ms", &SlmConfig::settle_ms, "settle time after a new hologram, milliseconds",
            limits::kSettleMs),
      field("allow_primary", &SlmConfig::allow_primary,
            "whether the only or primary display may be the SLM")};
};

template <>
struct Table<ConfiguredTracking> {
  static constexpr const char* kName = "TrackingConfig";
  static constexpr auto kFields =
      Fields{based<TrackingSettings>(),
             field("kernel_radius", &ConfiguredTracking::kernel_radius,
                   "the LG kernel's 1/e radius in units of lambda/d on the camera",
                   limits::kKernelRadius)};
};

template <>
struct Table<StreamConfig> {
  static constexpr const char* kName = "StreamConfig";
  static constexpr auto kFields =
      Fields{field("endpoint", &StreamConfig::endpoint, "ZeroMQ endpoint").checked(is_no_endpoint),
             field("image_endpoint", &StreamConfig::image_endpoint, "ZeroMQ endpoint")
                 .checked(is_no_endpoint),
             field("image_rate_hz", &StreamConfig::image_rate_hz,
                   "images and phase maps per second; 0: none", limits::kImageRateHz)};
};

template <>
struct Table<ControlConfig> {
  static constexpr const char* kName = "ControlConfig";
  static constexpr auto kFields = Fields{
      field("endpoint", &ControlConfig::endpoint, "ZeroMQ endpoint").checked(is_no_endpoint)};
};

template <>
struct Table<SecurityConfig> {
  static constexpr const char* kName = "SecurityConfig";
  static constexpr auto kFields =
      Fields{field("secret_key", &SecurityConfig::secret_key,
                   "file of the daemon's keys; null: no client needs a key")
                 .checked(is_empty_path),
             field("clients", &SecurityConfig::clients,
                   "file of the clients that may connect, with their roles")
                 .checked(is_empty_path)};
  static void check(const SecurityConfig& security, ObjectReader& reader) {
    if (security.secret_key.has_value() == security.clients.has_value()) return;
    reader.fault(security.clients ? "secret_key" : "clients",
                 "secret_key and clients are required together: name both files, or neither");
  }
};

template <>
struct Table<StateConfig> {
  static constexpr const char* kName = "StateConfig";
  static constexpr auto kFields =
      Fields{field("directory", &StateConfig::directory, "folder; null: $STATE_DIRECTORY")
                 .checked(is_empty_path)};
};

template <>
struct Table<RecordConfig> {
  static constexpr const char* kName = "RecordConfig";
  static constexpr auto kFields = Fields{
      field("directory", &RecordConfig::directory, "folder; null: recordings in the state's folder")
          .checked(is_empty_path),
      field("buffer_mib", &RecordConfig::buffer_mib,
            "memory for images that wait for the disk, MiB", limits::kRecordBufferMib)};
};

template <>
struct Table<ConfiguredPipeline> {
  static constexpr const char* kName = "PipelineConfig";
  static constexpr auto kFields =
      Fields{field("workers", &ConfiguredPipeline::workers,
                   "tracker threads; 0: the frame path runs in one thread", limits::kWorkers),
             field("records", &ConfiguredPipeline::records,
                   "maximum number of frames in flight, a power of two", limits::kRecords)
                 .checked(is_no_power_of_two),
             field("cpus", &ConfiguredPipeline::cpus,
                   "CPUs that the threads of the frame path may use; empty: any", limits::kCpu)
                 .sized(0, limits::kMaxCpus)
                 .unlike()};
};

template <>
struct Table<LogConfig> {
  static constexpr const char* kName = "LogConfig";
  static constexpr auto kFields =
      Fields{field("level", &LogConfig::level, "minimum severity of the lines that are written")};
};

template <>
struct Table<Config> {
  static constexpr const char* kName = "Config";
  static constexpr auto kFields =
      Fields{field("camera", &Config::camera, "the camera"),
             field("slm", &Config::slm, "the spatial light modulator"),
             field("optics", &Config::optics, "lens and camera"),
             field("sensor", &Config::sensor, "the sensor's hologram"),
             field("tracking", &Config::tracking, "how spots are found"),
             field("refine", &Config::refine,
                   "live refinement: fits the diffraction model to every pixel"),
             field("stream", &Config::stream, "data streams"),
             field("control", &Config::control, "command socket"),
             field("security", &Config::security, "keys and clients; both files, or neither"),
             field("state", &Config::state, "state kept across restarts"),
             field("record", &Config::record, "recordings"),
             field("realtime", &Config::realtime,
                   "whether a missing real-time privilege is an error or a warning"),
             field("pipeline", &Config::pipeline, "the frame path"),
             field("log", &Config::log, "the log")};
  static void check(const Config& config, ObjectReader& reader);
};

}  // namespace ovws
