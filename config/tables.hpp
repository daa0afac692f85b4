/// Field tables of the configuration file, in the order of ovwsd.json.
#pragma once

#include <optional>
#include <string>

#include "config/config.hpp"
#include "proto/endpoint.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/devices.hpp"
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
  return bind_fault(text);
}
inline std::optional<std::string> is_no_power_of_two(const int& number) {
  if ((number & (number - 1)) == 0) return std::nullopt;
  return "must be a power of two, not " + std::to_string(number);
}

template <>
inline constexpr NamesOf kNames<RealtimePolicy> = texts<"enforce", "ignore">;

template <>
inline constexpr NamesOf kNames<LogLevel> = texts<"trace", "debug", "info", "warn", "error">;

template <>
inline constexpr auto kTable<CameraConfig> =
    Fields{"CameraConfig",
           field<&CameraConfig::driver>("which camera driver").checked(is_empty),
           field<&CameraConfig::id>("GenICam id or address").checked(is_empty),
           inlined(&CameraConfig::settings),
           field<&CameraConfig::trigger>(
               "GenICam name of the input whose pulse starts each exposure, e.g. Line0; empty: the "
               "camera runs freely"),
           field<&CameraConfig::packet_size_bytes>("GigE Vision packet size, bytes",
                                                   limits::kPacketSizeBytes),
           field<&CameraConfig::transfer_ms>(
               "longest time from the end of an exposure to the frame's arrival, milliseconds",
               limits::kTransferMs)};

template <>
inline constexpr auto kTable<SlmConfig> =
    Fields{"SlmConfig",
           field<&SlmConfig::driver>("which display driver").checked(is_empty),
           based<SlmSettings>(),
           inlined(&SlmConfig::geometry),
           field<&SlmConfig::lut>("look-up table: file of 256 grey levels; null: linear"),
           field<&SlmConfig::flatness>(
               "flatness map: file of the phase to add at each pixel; null: none")};

template <>
inline constexpr NamesOf kNames<Modulator> = texts<"slm", "fixed", "dmd">;

template <>
inline constexpr auto kTable<PlateConfig> = Fields{
    "PlateConfig", field<&PlateConfig::levels>("steps of a turn; 0: smooth", limits::kPlateLevels),
    field<&PlateConfig::depth>("depth relative to the design", limits::kPlateDepth),
    field<&PlateConfig::shift_um>(
        "[x, y] of the spiral's axis from the lenslet's centre, micrometres",
        limits::kPlateShiftUm)};

template <>
inline constexpr auto kTable<ArrayConfig> =
    Fields{"ArrayConfig",
           field<&ArrayConfig::pitch_um>("distance of neighbouring lenslets, micrometres",
                                         limits::kLensletPitchUm),
           field<&ArrayConfig::shape>(
               "shape of a lenslet; null: the one that fills the grid, square or hexagon"),
           field<&ArrayConfig::pupil_mm>("diameter of the pupil on the array, millimetres; null: "
                                         "the largest circle of lit lenslets",
                                         limits::kPupilMm),
           field<&ArrayConfig::plate>("the spiral phase plates, if sensor.charge is not 0")};

/// 1 to 16 lower-case letters, digits, - and _; not the name of the main source.
std::optional<std::string> is_no_beam_name(const std::string& name);
template <>
inline constexpr auto kTable<BeamConfig> =
    Fields{"BeamConfig",
           field<&BeamConfig::name>("name of the source; its messages are wavefront.NAME and "
                                    "spots.NAME")
               .mandatory()
               .checked(is_no_beam_name),
           field<&BeamConfig::offset_px>(
               "[x, y] by which its spots lie beside the main source's, camera pixels; "
               "reference.take measures it",
               limits::kCentrePx)
               .mandatory()};

/// One slot has no room for a mark and a pattern.
inline std::optional<std::string> is_one_slot(const int& slots) {
  return slots == 1 ? std::optional<std::string>("must be 0, or 2 to 24") : std::nullopt;
}
static_assert(limits::kPatternSlots.max == kMaxPatternSlots);
template <>
inline constexpr NamesOf kNames<BitOrder> = texts<"GRB", "RGB", "BGR">;

template <>
inline constexpr auto kTable<DmdConfig> =
    Fields{"DmdConfig",
           field<&DmdConfig::apodisation>(
               "fraction by which the amplitude falls from a subaperture's centre to its rim",
               limits::Numbers{0.0, 1.0}),
           field<&DmdConfig::amplitudes>(
               "amplitude of each subaperture, relative to the largest possible; empty: 1 for all",
               limits::Numbers{0.01, 1.0})
               .sized(0, kMaxSubapertures),
           field<&DmdConfig::slots>(
               "pattern mode: number of bits of each pixel that the DMD plays one after the other "
               "in each frame of the video input; 0: it shows grey levels",
               limits::kPatternSlots)
               .checked(is_one_slot),
           field<&DmdConfig::bit_order>("order in which it plays the colours' bits, each from the "
                                        "lowest to the highest")};

template <>
inline constexpr auto kTable<ConfiguredTracking> = Fields{
    "TrackingConfig", based<TrackingSettings>(),
    field<&ConfiguredTracking::kernel_radius>(
        "the LG kernel's 1/e radius in units of lambda/d on the camera", limits::kKernelRadius)};

template <>
inline constexpr auto kTable<StreamConfig> = Fields{
    "StreamConfig", field<&StreamConfig::endpoint>("ZeroMQ endpoint").checked(is_no_endpoint),
    field<&StreamConfig::image_endpoint>("ZeroMQ endpoint").checked(is_no_endpoint),
    field<&StreamConfig::image_rate_hz>("images and phase maps per second; 0: none",
                                        limits::kImageRateHz)};

template <>
inline constexpr auto kTable<ControlConfig> = Fields{
    "ControlConfig", field<&ControlConfig::endpoint>("ZeroMQ endpoint").checked(is_no_endpoint)};

template <>
inline constexpr auto kTable<SecurityConfig> = Fields{
    "SecurityConfig",
    field<&SecurityConfig::secret_key>("file of the daemon's keys; null: no client needs a key")
        .checked(is_empty_path),
    field<&SecurityConfig::clients>("file of the clients that may connect, with their roles")
        .checked(is_empty_path)};
template <>
struct Rules<SecurityConfig> {
  static void check(const SecurityConfig& security, ObjectReader& reader) {
    if (security.secret_key.has_value() == security.clients.has_value()) return;
    reader.fault(security.clients ? "secret_key" : "clients",
                 "secret_key and clients are required together: name both files, or neither");
  }
};

template <>
inline constexpr auto kTable<StateConfig> =
    Fields{"StateConfig",
           field<&StateConfig::directory>("folder; null: $STATE_DIRECTORY").checked(is_empty_path)};

template <>
inline constexpr auto kTable<RecordConfig> =
    Fields{"RecordConfig",
           field<&RecordConfig::directory>("folder; null: recordings in the state's folder")
               .checked(is_empty_path),
           field<&RecordConfig::buffer_mib>("memory for images that wait for the disk, MiB",
                                            limits::kRecordBufferMib)};

template <>
inline constexpr auto kTable<ConfiguredPipeline> =
    Fields{"PipelineConfig",
           field<&ConfiguredPipeline::workers>(
               "tracker threads; 0: the frame path runs in one thread", limits::kWorkers),
           field<&ConfiguredPipeline::records>("maximum number of frames in flight, a power of two",
                                               limits::kRecords)
               .checked(is_no_power_of_two),
           field<&ConfiguredPipeline::cpus>(
               "CPUs that the threads of the frame path may use; empty: any", limits::kCpu)
               .sized(0, limits::kMaxCpus)
               .unlike()};

template <>
inline constexpr auto kTable<LogConfig> =
    Fields{"LogConfig", field<&LogConfig::level>("minimum severity of the lines that are written")};

template <>
inline constexpr auto kTable<Config> = Fields{
    "Config",
    field<&Config::modulator>("what makes the subapertures: slm, its hologram; fixed, an array of "
                              "lenslets, described by array, without a display; dmd, the "
                              "binary hologram of a micromirror device"),
    field<&Config::camera>("the camera"),
    field<&Config::slm>("the spatial light modulator"),
    field<&Config::optics>("lens and camera"),
    field<&Config::sensor>("the sensor's hologram"),
    field<&Config::array>("the fixed array of lenslets, with modulator fixed"),
    field<&Config::beams>("further light sources on the camera, in regions of their own")
        .sized(0, kMaxBeams),
    field<&Config::dmd>("how a micromirror device diffracts, with modulator dmd"),
    field<&Config::tracking>("how spots are found"),
    field<&Config::refine>("live refinement: fits the diffraction model to every pixel"),
    field<&Config::stream>("data streams"),
    field<&Config::control>("command socket"),
    field<&Config::security>("keys and clients; both files, or neither"),
    field<&Config::state>("state kept across restarts"),
    field<&Config::record>("recordings"),
    field<&Config::realtime>("whether a missing real-time privilege is an error or a warning"),
    field<&Config::pipeline>("the frame path"),
    field<&Config::log>("the log")};
template <>
struct Rules<Config> {
  static void check(const Config& config, ObjectReader& reader);
};

}  // namespace ovws
