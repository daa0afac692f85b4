/// The message `status` as a plain struct. Its field tables are in tables/status.hpp, which takes
/// seconds to compile.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/port/camera.hpp"
#include "core/port/display.hpp"
#include "core/rt/latency_histogram.hpp"
#include "proto/tables/record.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

struct StatusMessage {
  std::uint64_t seq = 0;  ///< message number of the stream
  std::int64_t t_ns = 0;
  double uptime_s = 0.0;
  std::string state;                 ///< name of the state machine's state
  std::optional<std::string> fault;  ///< cause of the state `fault`, and the remedy

  struct CameraPart {
    bool connected = false, streaming = false;
    std::optional<double> brightest;
    std::optional<CameraInfo> info;
    CameraSettings settings;           ///< in use; if not connected, those that will be applied
    std::optional<std::string> fault;  ///< what is wrong, and the remedy
  } camera;
  struct SlmPart {
    bool connected = false;
    std::optional<DisplayInfo> info;
    std::string pattern = "sensor";
    std::uint64_t hologram_id = 0;  ///< shown on the SLM; 0: none
    bool settled = false;
    std::optional<std::string> fault;
  } slm;
  struct SensorPart {
    SensorSettings settings;
    OperatorReport mode_operator;
    int subapertures = 0, modes = 0;
    bool measurable = true;  ///< whether there is a measurement plan for the camera's image
    bool referenced = false;
    std::string reference = "none";               ///< "none", "in_force", "stale"
    double reference_introduced_rms_waves = 0.0;  ///< introduced aberration within the reference
    /// Why spots lie outside the camera's region or too close together for the tracker; encoded as
    /// null if empty.
    std::string layout_fault;
    /// Why no frame is valid although frames are settled, or why the reference is not used.
    struct Invalid {
      std::int64_t t_since_ns = 0;  ///< UTC
      std::string reason;
      std::string action;  ///< what the daemon or the user does next, and when
      int searches = 0;    ///< wavefront searches since t_since_ns
      std::optional<std::int64_t> t_next_search_ns;  ///< UTC; none: a search is running
    };
    std::optional<Invalid> invalid;
    /// A further light source.
    struct Beam {
      std::string name;
      Vec2 offset_px;
      bool referenced = false;
      std::optional<std::string> reason;  ///< why its frames are not valid; none: they are
    };
    std::vector<Beam> beams;
  } sensor;
  bool loop_closed = false;
  bool loop_paused = false;  ///< only if it is closed
  struct RefinePart {
    std::string state = "off";            ///< "off", "waiting", "refining"
    std::uint64_t done = 0, refused = 0;  ///< since the start
    std::optional<double> last_duration_ms;
    std::optional<std::string> reason;  ///< why there is no refinement now
  } refine;

  RecordReport record;

  struct StorePart {
    std::optional<std::string> directory;  ///< folder of data that survive a restart
    std::optional<std::string> reason;     ///< why an item is not stored
  } store;

  struct FailedJob {
    int job = 0;
    std::string kind, field, reason;
    std::int64_t t_failed_ns = 0;
  };
  /// The last failed job whose kind has not succeeded since.
  std::optional<FailedJob> failed_job;

  struct Rates {
    double grabbed_hz = 0.0, published_hz = 0.0, images_hz = 0.0;  ///< mean of the last second
    std::optional<double> expected_hz;  ///< grabbed_hz of a camera as fast as it is set to
  } rates;
  std::vector<std::pair<std::string, std::uint64_t>> counters;  ///< counts since the daemon started
  std::vector<std::pair<std::string, LatencySummary>> latency;  ///< per processing stage
  std::vector<std::pair<std::string, std::string>> versions;    ///< "ovws", "aravis", …
};

}  // namespace ovws
