/// The daemon's configuration: one struct per section, every key has a default. The keys of
/// `camera`, `optics`, `sensor`, `tracking` and `refine` are in the included headers. The file `{}`
/// is valid.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/control/refine_settings.hpp"
#include "core/optics/dmd.hpp"
#include "core/optics/geometry.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/port/camera.hpp"
#include "core/port/display.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// The camera driver that plays a recording: its id is the path of the file.
constexpr const char* kReplayDriver = "replay";

struct CameraConfig {
  std::string driver = "aravis";
  std::string id = "127.0.0.1";  ///< GenICam id, or address
  CameraSettings settings;
  std::string trigger{};  ///< input that starts each exposure, e.g. "Line0"; empty: none
  int packet_size_bytes = 9000;
  double transfer_ms = 10.0;  ///< longest time from the end of an exposure to the frame's arrival
};

struct SlmConfig : SlmSettings {
  std::string driver = "sdl";
  SlmGeometry geometry;                 ///< keys width, height, pitch_um
  std::optional<std::string> lut;       ///< table file: 256 grey levels for equal phase steps
  std::optional<std::string> flatness;  ///< flatness map file: see config/README.md
};

enum class Modulator {
  slm,    ///< the SLM's hologram makes the subapertures
  fixed,  ///< an array of lenslets does, which nothing can change
  dmd,    ///< the binary hologram of a micromirror device does; the keys of `slm` describe it
};

/// The spiral phase plate in each lenslet, if sensor.charge is not 0; see SpiralPlate.
struct PlateConfig {
  int levels = 0;
  double depth = 1.0;
  Vec2 shift_um;  ///< of the axis from the lenslet's centre
};

/// A fixed array of lenslets.
struct ArrayConfig {
  double pitch_um = 150.0;            ///< distance of neighbouring lenslets
  std::optional<LensletShape> shape;  ///< none: filling_shape of the grid
  std::optional<double> pupil_mm;     ///< diameter on the array; none: see lenslet_pupil
  PlateConfig plate;
};

struct StreamConfig {
  std::string endpoint = "tcp://127.0.0.1:7701";
  std::string image_endpoint = "tcp://127.0.0.1:7703";
  double image_rate_hz = 10.0;
};

struct ControlConfig {
  std::string endpoint = "tcp://127.0.0.1:7702";
};

struct StateConfig {
  /// Folder of the state kept across restarts; none: $STATE_DIRECTORY, else nothing is kept.
  std::optional<std::string> directory;
};

struct RecordConfig {
  /// Folder for recordings; none: `recordings` in the state's folder, if there is one.
  std::optional<std::string> directory;
  int buffer_mib = 256;  ///< memory for images that wait for the disk while recording
};

struct SecurityConfig {
  std::optional<std::string> secret_key;  ///< key file of ovws keygen; if set, clients need keys
  std::optional<std::string> clients;     ///< file of the clients that may connect, and their roles
};

enum class RealtimePolicy {
  enforce,  ///< a missing privilege is a start-up error
  ignore,   ///< a missing privilege is a warning
};

enum class LogLevel { trace, debug, info, warn, error };

struct LogConfig {
  LogLevel level = LogLevel::info;
};

/// Tracking settings with the LG kernel's radius, which only the configuration file sets.
struct ConfiguredTracking : TrackingSettings {
  ConfiguredTracking() = default;
  ConfiguredTracking(const TrackingSettings& settings)  // NOLINT(google-explicit-constructor)
      : TrackingSettings(settings) {}
};

struct ConfiguredPipeline : PipelineConfig {
  std::vector<int> cpus;  ///< CPU affinity of the frame path's threads; empty: any CPU
};

/// A further light source: it gives the same spots as the main one, elsewhere on the camera.
struct BeamConfig {
  std::string name;  ///< suffix of its topics: wavefront.NAME, spots.NAME
  Vec2 offset_px;    ///< of its spots from the main source's, camera pixels
  friend bool operator==(const BeamConfig&, const BeamConfig&) = default;
};
/// Name that stands for the main source where a source is chosen.
constexpr const char* kMainBeam = "main";

struct Config {
  Modulator modulator = Modulator::slm;
  CameraConfig camera;
  SlmConfig slm;
  OpticsConfig optics;
  SensorConfig sensor;
  ArrayConfig array;
  std::vector<BeamConfig> beams;  ///< at most kMaxBeams
  DmdConfig dmd;
  ConfiguredTracking tracking;
  RefineSetup refine;  ///< in DN of the camera's pixel_format
  StreamConfig stream;
  ControlConfig control;
  SecurityConfig security;
  StateConfig state;
  RecordConfig record;
  RealtimePolicy realtime = RealtimePolicy::ignore;
  ConfiguredPipeline pipeline;
  LogConfig log;
};

/// Completes a configuration with a fixed array: no display (driver `none`), the array in place of
/// the SLM's pixels, and the lenslets that a centred array without rotation has in the camera's
/// region. registration.run replaces them. No effect with an SLM.
void use_modulator(Config& config);
/// Lenslets in use of an array: their places on the camera and how the array lies there.
struct ArrayOnCamera {
  double pitch_px = 0.0;      ///< distance of neighbouring lenslets, camera pixels
  double rotation_deg = 0.0;  ///< as in Lenslets
  double pupil_diameter_px = 0.0;
  std::vector<Vec2> centres_px{};
};
/// The sensor with these lenslets.
SensorConfig sensor_with(const Config& config, ArrayOnCamera lenslets);
/// Expected distance of neighbouring lenslets on the camera, camera pixels.
double lenslet_pitch_px(const ArrayConfig& array, const OpticsConfig& optics);
/// Magnification from the array's focal plane to the camera, by the lenslets' distance there.
double magnification_of(const Config& config, double pitch_px);

/// Parses strictly: unknown keys, wrong types and values out of range are errors that name the
/// dotted path and, for an unknown key, the closest valid one. Allows comments (// and /* */).
Result<Config> parse_config(const std::string& json_text);
/// Reads and parses a configuration file. Makes its paths absolute: relative ones start from the
/// file's folder. The reason of an error names the file.
Result<Config> load_config(const std::string& path);
/// JSON text with all keys, defaults included; parse_config(dump_config(c)) equals c.
std::string dump_config(const Config& config);

}  // namespace ovws
